// The options of how a file is read, which every command that reads one has.
#include <CLI/CLI.hpp>
#include <holdfast/program/program.hpp>

namespace holdfast::program {

void add_reading(CLI::App& command, ReadingArguments& arguments) {
  command
      .add_option(
          "--g2o-rotations", arguments.g2o_rotations,
          "what the rotations in the informations of EDGE_SE3:QUAT are of: half the angle, as g2o has it, or the full angle, as GTSAM "
          "writes it")
      ->check(CLI::IsMember({"half", "full"}))
      ->capture_default_str();
  command
      .add_option("--toro-order", arguments.toro_order,
                  "of the informations of EDGE2: toro (11 12 22 33 13 23), or rows (iSAM, HOG-Man, SLAM++)")
      ->check(CLI::IsMember({"toro", "rows"}))
      ->capture_default_str();
  command
      .add_option(
          "--isam-noise", arguments.isam_noise,
          "what the numbers after ODOMETRY and LANDMARK are: the square root of an information, as iSAM has it, an information, or a "
          "covariance")
      ->check(CLI::IsMember({"root", "information", "covariance"}))
      ->capture_default_str();
  command
      .add_option("--indefinite", arguments.indefinite,
                  "an information with a negative eigenvalue is refused, or replaced by the nearest matrix without (repair)")
      ->check(CLI::IsMember({"refuse", "repair"}))
      ->capture_default_str();
  command
      .add_option("--odometry", arguments.odometry,
                  "which relative poses are odometry, and so under no loss: consecutive (between consecutive steps of one agent, in either "
                  "direction), none, or the tag of their lines")
      ->capture_default_str();
}

ReadOptions read_options(const ReadingArguments& arguments) {
  ReadOptions options;
  options.full_angle = arguments.g2o_rotations == "full";
  options.toro_rows = arguments.toro_order == "rows";
  options.repair = arguments.indefinite == "repair";
  if (arguments.isam_noise == "information") options.isam_noise = ReadOptions::IsamNoise::information;
  if (arguments.isam_noise == "covariance") options.isam_noise = ReadOptions::IsamNoise::covariance;
  return options;
}

}  // namespace holdfast::program
