#include <gtest/gtest.h>

#include <filesystem>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/internal/text.hpp>
#include <holdfast/graph/function_factor.hpp>
#include <holdfast/solvers/incremental/incremental.hpp>
#include <holdfast/testing.hpp>

namespace holdfast {
namespace {

using testing::uniform;

constexpr Agent x('x'), L('L');
const Vector<3> kSigmas(0.05, 0.05, 0.02);

/// Walks in circles past a beacon: odometry, ranges with a loss, loops; now and then a factor or a pose goes.
void walk(Incremental& smoother, int k, std::uint64_t seed) {
  std::mt19937_64 rng(seed * 1000 + static_cast<std::uint64_t>(k));
  if (k == 0) {
    smoother.insert(x(0), Pose2(0, 0, 0));
    smoother.add(Prior<Pose2>::from_sigmas(Pose2(), kSigmas), {x(0)});
    smoother.insert(L(0), Point2(2, 3));
    smoother.add(Prior<Point2>::from_sigmas(Point2(2, 3), Vector<2>(1, 1)), {L(0)});
    smoother.insert(L(1), Point2(-4, 1));
    smoother.fix(L(1));
    return;
  }
  const Pose2 step(0.5 + uniform(rng, -0.02, 0.02), 0, 0.1 + uniform(rng, -0.01, 0.01));
  smoother.insert(x(k), smoother.at<Pose2>(x(k - 1)) * step);
  smoother.add(Between<Pose2>::from_sigmas(step, kSigmas), {x(k - 1), x(k)});
  for (unsigned j = 0; j < 2; ++j) smoother.add(Range<Pose2, Point2>{uniform(rng, 2, 6), 0.5}, {x(k), L(j)}, Huber{2});
  if (k > 62) smoother.add(Between<Pose2>::from_sigmas(Pose2(0.1, 0.1, 0), kSigmas), {x(k - 62), x(k)}, Cauchy{1});
  if (k % 7 == 0) smoother.remove(smoother.graph().factors_on(L(0)).back());
}

/// The estimate and the cost, bit by bit.
std::string bits(const Incremental& smoother) {
  const Values values = smoother.values();
  std::string all;
  for (const Key key : values.keys()) {
    const auto& slot = values.slot(key);
    const PoolBase& pool = values.pool(slot.pool);
    all.append(reinterpret_cast<const char*>(pool.data(slot.index)), sizeof(double) * static_cast<std::size_t>(pool.ambient()));
  }
  const double cost = smoother.cost();
  return all.append(reinterpret_cast<const char*>(&cost), sizeof cost);
}

class IncrementalFile : public ::testing::Test {
 protected:
  ~IncrementalFile() override { std::filesystem::remove(path_); }
  const std::string path_ = ::testing::TempDir() + "holdfast_incremental";
};

TEST_F(IncrementalFile, WhatFollowsHasTheSameBits) {
  for (const int at : {1, 30, 63, 90}) {
    for (const bool before_update : {false, true}) {
      Incremental one, other;
      for (int k = 0; k < 120; ++k) {
        walk(one, k, 1);
        if (k == at && before_update) one.save(path_, "a note");
        one.update();
        if (k == at && !before_update) one.save(path_, "a note");
        if (k < at) continue;
        if (k == at) {
          EXPECT_EQ(other.restore(path_), "a note");
          if (before_update) other.update();
        } else {
          walk(other, k, 1);
          other.update();
        }
        ASSERT_TRUE(bits(one) == bits(other)) << "saved at " << at << ", differs at " << k;
      }
      one.finish();
      other.finish();
      EXPECT_TRUE(bits(one) == bits(other));
      EXPECT_EQ(one.covariance({x(5), x(100)}), other.covariance({x(5), x(100)}));
    }
  }
}

TEST_F(IncrementalFile, ARefusedFileLeavesNoTrace) {
  Incremental smoother;
  for (int k = 0; k < 40; ++k) {
    walk(smoother, k, 2);
    smoother.update();
  }
  smoother.save(path_);
  const std::string file = io::read_file(path_), before = bits(smoother);
  const auto refused = [&](const std::string& bytes, const char* why) {
    atomic_write(path_, bytes);
    try {
      smoother.restore(path_);
      ADD_FAILURE() << "taken: " << why;
    } catch (const BadFile& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
    EXPECT_TRUE(bits(smoother) == before);
  };
  refused("something else", "no file of a holdfast incremental smoother");
  refused(file.substr(0, file.size() / 2), "torn");
  std::string changed = file;
  changed[file.size() / 2] ^= 1;
  refused(changed, "checksum");
  std::filesystem::remove(path_);
  EXPECT_THROW(smoother.restore(path_), BadFile);
}

TEST_F(IncrementalFile, AFunctionCannotBeWritten) {
  auto function = std::make_shared<FunctionFactors>();
  function->name = "Stay";
  function->types = {&Pool<Point2>::prototype()};
  function->residual_dim = 2;
  function->evaluate = [](const FunctionCall& call) { std::copy_n(call.x[0], 2 * call.n, call.r); };
  Graph graph;
  const FactorId id = graph.add(function, {L(0)})[0];
  Incremental smoother;
  smoother.insert(L(0), Point2(1, 2));
  smoother.add_from(graph, id);
  smoother.update();
  EXPECT_THROW(smoother.save(path_), BadFile);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

}  // namespace
}  // namespace holdfast
