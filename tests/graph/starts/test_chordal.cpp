// The chordal start: exact where measurements are, equivariant, and in the better valley where dead reckoning is not.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/graph/starts/chordal.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/testing.hpp>

namespace holdfast::testing {
namespace {

constexpr Agent x('x');

template <class Pose>
RelativePoseEdge<Pose> edge_of(int first, int second, const Pose& measured, double turns_known = 1) {
  RelativePoseEdge<Pose> edge{x(first), x(second), measured, {}, {}};
  constexpr int turns = Pose::dim - Pose::space_dim;
  edge.noise.written.template bottomRightCorner<turns, turns>() *= 1 / turns_known;  // a covariance
  return edge;
}

/// Poses anywhere, turned anyhow, each seen from the one before and from another one; no vertices.
template <class Pose>
struct Tangle {
  std::vector<Pose> truth;
  Dataset data;

  explicit Tangle(double sigma, unsigned seed = 5, int poses = 40) {
    std::mt19937_64 rng(seed);
    for (int k = 0; k < poses; ++k) truth.push_back(k == 0 ? Pose() : random_variable<Pose>(rng));
    for (int k = 1; k < poses; ++k)
      for (const int from : {k - 1, k / 2}) {
        const Pose seen = truth[from].inverse() * truth[k];
        data.edges.push_back({edge_of<Pose>(from, k, seen.retract(random_vector<Pose::dim>(rng, sigma)), 0.3 * k), {}, 0});
      }
  }
};

template <class Pose>
double largest_error(const Values& values, const std::vector<Pose>& truth, const Pose& T_world_truth = {}) {
  double largest = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) largest = std::max(largest, values.at<Pose>(x(k)).local(T_world_truth * truth[k]).norm());
  return largest;
}

template <class Pose>
class Chordal : public ::testing::Test {};
using Poses = ::testing::Types<Pose2, Pose3>;
TYPED_TEST_SUITE(Chordal, Poses);

TYPED_TEST(Chordal, ExactMeasurementsGiveTheTruth) {
  const Tangle<TypeParam> tangle(0);
  const Values values = chordal_start(tangle.data);
  EXPECT_EQ(values.size(), tangle.truth.size());
  EXPECT_LT(largest_error(values, tangle.truth), 1e-9);
}

// With exact rotations what is left is a linear problem, and the start is its minimum, whatever the information and however the
// measurements are turned: no translation has a gradient.
TYPED_TEST(Chordal, TranslationsMinimiseTheCostWhereRotationsAreExact) {
  using Pose = TypeParam;
  std::mt19937_64 rng(11);
  Tangle<Pose> tangle(0);
  tangle.data.format = Format::G2o;
  for (Edge& edge : tangle.data.edges) {
    auto& relative = std::get<RelativePoseEdge<Pose>>(edge.measurement);
    relative.measured.p += random_vector<Pose::space_dim>(rng, 0.5);
    relative.noise = {random_covariance<Pose::dim>(rng), Format::G2o};  // an information
  }
  tangle.data.fixed = {{x(0), 0}};
  const Problem problem = make_problem(tangle.data, {});
  const Gradient g = gradient(problem.graph, chordal_start(tangle.data));
  EXPECT_EQ(g.keys.size(), tangle.truth.size() - 1);
  EXPECT_GT(problem.graph.cost(chordal_start(tangle.data)), 1);
  for (const int offset : g.offsets)
    for (int c = 0; c < Pose::space_dim; ++c) EXPECT_NEAR(g.value[offset + c], 0, 1e-9);
}

TYPED_TEST(Chordal, HalfTurnsAreLikeAnyOther) {
  using Pose = TypeParam;
  std::vector<Pose> truth{Pose()};
  Dataset data;
  for (int k = 1; k < 30; ++k) {
    Vector<Pose::dim> step = Vector<Pose::dim>::Unit(0);
    step[Pose::space_dim + k % (Pose::dim - Pose::space_dim)] = kPi + (k % 3 - 1) * 1e-7;
    const Pose seen = Pose().retract(step);
    truth.push_back(truth.back() * seen);
    data.edges.push_back({edge_of<Pose>(k - 1, k, seen), {}, 0});
    if (k > 3) data.edges.push_back({edge_of<Pose>(k, k - 4, truth[k].inverse() * truth[k - 4]), {}, 0});
  }
  EXPECT_LT(largest_error(chordal_start(data), truth), 1e-9);
}

TYPED_TEST(Chordal, WhereItIsHeldDoesNotMatterToExactMeasurements) {
  using Pose = TypeParam;
  Tangle<Pose> tangle(0);
  std::mt19937_64 rng(2);
  for (const int held : {0, 17, 39}) {
    const Pose where = random_variable<Pose>(rng);
    tangle.data.vertices = {{x(held), where, {}, {}, 0}};
    tangle.data.fixed = {{x(held), 0}};
    const Values values = chordal_start(tangle.data);
    EXPECT_EQ(values.at<Pose>(x(held)).local(where).norm(), 0);
    EXPECT_LT(largest_error(values, tangle.truth, where * tangle.truth[held].inverse()), 1e-9) << held;
  }
}

TYPED_TEST(Chordal, MovesRigidlyWithWhatIsHeld) {
  using Pose = TypeParam;
  Tangle<Pose> tangle(0.1);
  const Values before = chordal_start(tangle.data);
  std::mt19937_64 rng(3);
  const Pose where = random_variable<Pose>(rng);
  tangle.data.vertices = {{x(0), where, {}, {}, 0}};
  const Values after = chordal_start(tangle.data);
  for (std::size_t k = 0; k < tangle.truth.size(); ++k)
    EXPECT_LT(after.at<Pose>(x(k)).local(where * before.at<Pose>(x(k))).norm(), 1e-9) << k;
}

TYPED_TEST(Chordal, HoldsAPartAtItsPrior) {
  using Pose = TypeParam;
  Tangle<Pose> tangle(0);
  std::mt19937_64 rng(4);
  const Pose where = random_variable<Pose>(rng);
  tangle.data.edges.push_back({PriorEdge<Pose>{x(8), where, {}, {}, {}}, {}, 0});
  EXPECT_LT(largest_error(chordal_start(tangle.data), tangle.truth, where * tangle.truth[8].inverse()), 1e-9);
}

TYPED_TEST(Chordal, SolvesEachPartForItself) {
  using Pose = TypeParam;
  Tangle<Pose> tangle(0);
  const Tangle<Pose> other(0, 6, 10);
  constexpr Agent y('y');
  for (Edge edge : other.data.edges) {
    auto& relative = std::get<RelativePoseEdge<Pose>>(edge.measurement);
    relative.first = y(relative.first.index());
    relative.second = y(relative.second.index());
    tangle.data.edges.push_back(edge);
  }
  std::mt19937_64 rng(5);
  const Pose where = random_variable<Pose>(rng), alone = random_variable<Pose>(rng);
  tangle.data.vertices = {{y(0), where, {}, {}, 0}, {Key('z', 0), alone, {}, {}, 0}};
  const Values values = chordal_start(tangle.data);
  EXPECT_LT(largest_error(values, tangle.truth), 1e-9);
  for (std::size_t k = 0; k < other.truth.size(); ++k) EXPECT_LT(values.at<Pose>(y(k)).local(where * other.truth[k]).norm(), 1e-9) << k;
  EXPECT_EQ(values.at<Pose>(Key('z', 0)).local(alone).norm(), 0);
}

TEST(ChordalStart, LandmarksFollowThePosesThatSawThem) {
  Tangle<Pose2> tangle(0);
  constexpr Agent L('L');
  const Vector<2> landmark(3, -4);
  const Pose2& seen_from = tangle.truth[30];
  tangle.data.edges.push_back(
      {RelativePointEdge<Point2>{x(30), L(0), Point2(seen_from.to_body(landmark - seen_from.p).eval()), {}, {}, {}}, {}, 0});
  tangle.data.vertices.push_back({L(1), Point2(7.0, 8.0), {}, {}, 0});
  const Values values = chordal_start(tangle.data);
  EXPECT_LT((values.at<Point2>(L(0)).value - landmark).norm(), 1e-9);
  EXPECT_EQ(values.at<Point2>(L(1)).value, Vector<2>(7, 8));
}

TYPED_TEST(Chordal, AGraphHasTheStartOfItsFile) {
  Tangle<TypeParam> tangle(0.1);
  tangle.data.fixed = {{x(0), 0}};
  const Problem problem = make_problem(tangle.data, {});
  std::mt19937_64 rng(8);
  Values values = problem.start;
  for (std::size_t k = 1; k < tangle.truth.size(); ++k)
    values.update(x(k), random_variable<TypeParam>(rng));  // where they are now is no matter
  ASSERT_TRUE(chordal_start(problem.graph, values));
  const Values expected = chordal_start(tangle.data);
  for (std::size_t k = 0; k < tangle.truth.size(); ++k)
    EXPECT_LT(values.at<TypeParam>(x(k)).local(expected.at<TypeParam>(x(k))).norm(), 1e-9) << k;
}

TEST(ChordalStart, LeavesAGraphAloneThatHasMoreThanPoses) {
  const Tangle<Pose2> tangle(0.1);
  Problem problem = make_problem(tangle.data, {});
  constexpr Agent L('L');
  problem.start.insert(L(0), Point2(1, 2));
  problem.graph.add(Range<Pose2, Point2>{3, 1}, {x(4), L(0)});
  Values values = problem.start;
  EXPECT_FALSE(chordal_start(problem.graph, values));
  EXPECT_EQ(values.at<Pose2>(x(7)).local(problem.start.at<Pose2>(x(7))).norm(), 0);
  problem.graph.fix(L(0));
  EXPECT_TRUE(chordal_start(problem.graph, values));
}

TEST(ChordalStart, ASingularPartStaysWhereItsVerticesAre) {
  Tangle<Pose3> tangle(0);
  for (Edge& edge : tangle.data.edges) {
    auto& relative = std::get<RelativePoseEdge<Pose3>>(edge.measurement);
    relative.noise = {Matrix<6, 6>::Zero(), Format::G2o};
  }
  const Values start = vertex_start(tangle.data), values = chordal_start(tangle.data);
  EXPECT_LT(largest_error(values, tangle.truth), 1e-9);  // which the edges alone give, too
  for (const Key key : start.keys()) EXPECT_EQ(values.at<Pose3>(key).local(start.at<Pose3>(key)).norm(), 0);
}

TEST(ChordalStart, StartsHaveNames) {
  EXPECT_EQ(start_named("chordal"), ProblemOptions::Start::chordal);
  EXPECT_EQ(start_named("odometry"), ProblemOptions::Start::odometry);
  EXPECT_EQ(start_named("file"), ProblemOptions::Start::file);
  EXPECT_THROW(start_named("chord"), BadOption);
}

/// Boustrophedon through a cube of side³ poses, each facing its own way, and a closure to every neighbour on the grid.
Dataset noisy_cube(int side, double sigma_rotation, unsigned seed) {
  std::mt19937_64 rng(seed);
  std::vector<Pose3> truth;
  for (int k = 0; k < side * side * side; ++k) {
    const int z = k / (side * side), row = k / side % side, along = k % side;
    const int y = z % 2 == 0 ? row : side - 1 - row, across = (z * side + row) % 2 == 0 ? along : side - 1 - along;
    Vector<6> tangent = random_vector<6>(rng);
    tangent.head<3>() = Vector<3>(across, y, z);
    truth.push_back(Pose3().retract(tangent));
  }
  Dataset data;
  data.format = Format::G2o;
  for (int j = 0; j < static_cast<int>(truth.size()); ++j)
    for (int i = 0; i < j; ++i) {
      if ((truth[i].p - truth[j].p).norm() > 1.1) continue;
      Vector<6> noise = random_vector<6>(rng, sigma_rotation);
      noise.head<3>() *= 0.2;
      RelativePoseEdge<Pose3> edge = edge_of<Pose3>(i, j, (truth[i].inverse() * truth[j]).retract(noise));
      edge.noise = {Matrix<6, 6>::Identity() / (sigma_rotation * sigma_rotation), Format::G2o};
      edge.noise.written.topLeftCorner<3, 3>() *= 25;
      edge.noise.written.bottomRightCorner<3, 3>() *= 4;
      data.edges.push_back({edge, {}, 0});
    }
  return data;
}

double cost_from(const Dataset& data, ProblemOptions::Start start, double* first = nullptr, bool restart = false, int* restarts = nullptr) {
  const Problem problem = make_problem(data, {{}, start, 0});
  Values values = problem.start;
  Options options;
  options.max_iterations = 300;
  options.cost_tolerance = 1e-9;
  const Summary summary = Irls(options, {Reweighting::automatic, restart}).solve(problem.graph, values);
  EXPECT_TRUE(summary.usable()) << summary.str();
  if (!restart) {
    EXPECT_EQ(summary.restarts, 0);
  }
  if (restarts != nullptr) *restarts = summary.restarts;
  if (first != nullptr) *first = summary.cost_first;
  return summary.cost;
}

TEST(ChordalStart, IsInTheBetterValleyOfANoisyCube) {
  int lower = 0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Dataset data = noisy_cube(5, 0.3, seed);
    double chordal_first, odometry_first;
    const double chordal = cost_from(data, ProblemOptions::Start::chordal, &chordal_first);
    const double odometry = cost_from(data, ProblemOptions::Start::odometry, &odometry_first);
    int restarts = 0;
    EXPECT_LE(cost_from(data, ProblemOptions::Start::odometry, nullptr, true, &restarts), std::min(chordal, odometry) * (1 + 1e-6)) << seed;
    EXPECT_EQ(restarts, 1) << seed;
    std::cout << "  odometry " << odometry_first << " -> " << odometry << ", chordal " << chordal_first << " -> " << chordal << std::endl;
    EXPECT_LT(chordal_first, 0.1 * odometry_first);
    EXPECT_LE(chordal, odometry * (1 + 1e-6)) << seed;
    if (chordal < 0.9 * odometry) ++lower;
  }
  EXPECT_GE(lower, 1);
}

std::string path_of(const std::string& file) {
  const char* chosen = std::getenv("HOLDFAST_DATA");
  return (chosen != nullptr ? std::string(chosen) : std::string(HOLDFAST_SOURCE_DIR) + "/../shared/data") + "/" + file;
}

class OnData : public ::testing::TestWithParam<const char*> {};

TEST_P(OnData, EndsAtTheCostOfTheFilesStartOrLower) {
  const std::string path = path_of("pose_graph/" + std::string(GetParam()) + ".g2o");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there; set HOLDFAST_DATA";
  const Dataset data = read_dataset(path);
  double file_first, chordal_first;
  const double file = cost_from(data, ProblemOptions::Start::file, &file_first);
  const double chordal = cost_from(data, ProblemOptions::Start::chordal, &chordal_first);
  std::cout << "  file " << file_first << " -> " << file << ", chordal " << chordal_first << " -> " << chordal << std::endl;
  EXPECT_LE(chordal, file * (1 + 1e-6));
}

INSTANTIATE_TEST_SUITE_P(Files, OnData, ::testing::Values("intel", "MIT", "CSAIL", "M3500", "sphere2500", "smallGrid3D", "tinyGrid3D"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace holdfast::testing
