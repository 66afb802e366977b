// Runs the program in this process, so that sanitizers see it, and looks at what it leaves behind.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <holdfast/program/program.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

namespace holdfast::program {

struct Outcome {
  int code;
  std::string out, err;
};

inline Outcome holdfast_program(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"holdfast"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  std::ostringstream out, err;
  const int code = run(static_cast<int>(argv.size()), argv.data(), out, err);
  return {code, out.str(), err.str()};
}

/// A directory of the test's own, gone when it ends.
class InDirectory : public ::testing::Test {
 protected:
  InDirectory() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(::testing::TempDir()) /
            (std::string("holdfast_") + test->test_suite_name() + "_" + test->name() + "_" + std::to_string(::getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~InDirectory() override { std::filesystem::remove_all(path_); }

  std::string at(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(at(name), std::ios::binary) << content;
    return at(name);
  }

 private:
  std::filesystem::path path_;
};

inline std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline std::vector<nlohmann::ordered_json> lines_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<nlohmann::ordered_json> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(nlohmann::ordered_json::parse(line));
  return lines;
}

/// Two robots in the plane that meet by ranges; robot A's odometry is a little off. Vertices are truth.
inline std::string small_pyfg(int poses = 5) {
  std::ostringstream text;
  for (char agent : {'A', 'B'})
    for (int k = 0; k < poses; ++k) text << "VERTEX_SE2 " << k << ' ' << agent << k << ' ' << k << ' ' << (agent == 'A' ? 0 : 3) << " 0\n";
  text << "VERTEX_XY L0 2 7\n";
  for (char agent : {'A', 'B'})
    for (int k = 1; k < poses; ++k)
      text << "EDGE_SE2 " << k << ' ' << agent << k - 1 << ' ' << agent << k << (agent == 'A' ? " 1.02 0.01 0.002" : " 1 0 0")
           << " 0.01 0 0 0.01 0 0.0001\n";
  for (int k = 0; k < poses; ++k) text << "EDGE_RANGE " << k << " A" << k << " B" << k << (k == 2 ? " 30" : " 3") << " 0.01\n";
  for (int k = 0; k < poses; ++k) {
    text << "EDGE_RANGE " << k << " A" << k << " L0 " << std::hypot(2.0 - k, 7.0) << " 0.01\n";
    text << "EDGE_RANGE " << k << " B" << k << " L0 " << std::hypot(2.0 - k, 4.0) << " 0.01\n";
  }
  return text.str();
}

/// A square walked round, with its closure.
inline std::string small_g2o() {
  return "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1.1 0 1.6\nVERTEX_SE2 2 1 1.1 3.1\nVERTEX_SE2 3 0 1 -1.6\n"
         "EDGE_SE2 0 1 1 0 1.5707963 100 0 0 100 0 400\nEDGE_SE2 1 2 1 0 1.5707963 100 0 0 100 0 400\n"
         "EDGE_SE2 2 3 1 0 1.5707963 100 0 0 100 0 400\nEDGE_SE2 3 0 1 0.1 1.5707963 100 0 0 100 0 400\n";
}

}  // namespace holdfast::program
