// Our optimizer inside MRPT's graph-slam engine, without a window, beside MRPT's own.
// clang-format off: CLevMarqGSO.h uses headers that it does not include
#if __has_include(<mrpt/opengl/CDisk.h>)  // MRPT 2
#include <mrpt/opengl/CDisk.h>
#include <mrpt/opengl/CSphere.h>
#else
#include <mrpt/viz/CDisk.h>
#include <mrpt/viz/CGridPlaneXY.h>
#include <mrpt/viz/CSphere.h>
#endif
// clang-format on
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mrpt/graphslam/CGraphSlamEngine.h>
#include <mrpt/graphslam/GSO/CLevMarqGSO.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <holdfast/adapters/mrpt/optimizer.hpp>
#include <holdfast/graph/files/files.hpp>
#include <iostream>
#include <random>

namespace holdfast::testing {
namespace {

using namespace mrpt::graphs;
using namespace mrpt::graphslam;
using mrpt::obs::CActionCollection;
using mrpt::obs::CObservation;
using mrpt::obs::CSensoryFrame;
using mrpt::poses::CPose2D;
using Network = CNetworkOfPoses2DInf;
using Edge = Network::constraint_t;

// ---- a drive round a circle, twice: what the deciders hand to the engine, step by step

constexpr int kNodes = 60, kRound = 30;

struct Drive {
  std::vector<CPose2D> truth;
  std::vector<Edge> odometry;                               ///< to node k + 1
  std::vector<std::vector<std::pair<int, Edge>>> closures;  ///< of node k, to earlier ones
};

Edge edge_of(const CPose2D& step, double sigma, double sigma_angle, std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  Edge edge;
  edge.mean = CPose2D(step.x() + sigma * normal(rng), step.y() + sigma * normal(rng), step.phi() + sigma_angle * normal(rng));
  edge.cov_inv.setDiagonal(std::vector<double>{1 / (sigma * sigma), 1 / (sigma * sigma), 1 / (sigma_angle * sigma_angle)});
  return edge;
}

Drive make_drive(double false_closures, double sigma_angle = 0.005) {
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  Drive drive;
  CPose2D pose;
  for (int k = 0; k < kNodes; ++k) {
    drive.truth.push_back(pose);
    pose = pose + CPose2D(1, 0, 2 * kPi / kRound);
  }
  drive.closures.resize(kNodes);
  for (int k = 0; k + 1 < kNodes; ++k) drive.odometry.push_back(edge_of(drive.truth[k + 1] - drive.truth[k], 0.02, sigma_angle, rng));
  for (int k = kRound; k < kNodes; ++k)
    for (int j = k - kRound; j <= k - kRound + 1; ++j) {
      Edge closure = edge_of(drive.truth[k] - drive.truth[j], 0.02, sigma_angle, rng);
      if (uniform(rng) < false_closures) closure.mean = CPose2D(5 * uniform(rng), -5 * uniform(rng), 3 * uniform(rng));
      drive.closures[k].emplace_back(j, closure);
    }
  return drive;
}

class Nodes final : public deciders::CNodeRegistrationDecider<Network> {
 public:
  explicit Nodes(const Drive& drive) : drive_(drive) { initializeLoggers("Nodes"); }
  bool updateState(CActionCollection::Ptr, CSensoryFrame::Ptr, CObservation::Ptr) override {
    return registerNewNodeAtEnd(drive_.odometry[step_++]);
  }

 private:
  const Drive& drive_;
  int step_ = 0;
};

class Closures final : public deciders::CEdgeRegistrationDecider<Network> {
 public:
  explicit Closures(const Drive& drive) : drive_(drive) { initializeLoggers("Closures"); }
  bool updateState(CActionCollection::Ptr, CSensoryFrame::Ptr, CObservation::Ptr) override {
    const TNodeID last = m_graph->nodeCount() - 1;
    for (const auto& [to, edge] : drive_.closures[last]) m_graph->insertEdge(to, last, edge);
    return true;
  }

 private:
  const Drive& drive_;
};

/// An optimizer that keeps what it made of the nodes: the engine's Dijkstra estimate comes right after.
template <class Optimizer>
class Recorded final : public Optimizer {
 public:
  Network::global_poses_t nodes;
  bool updateState(CActionCollection::Ptr action, CSensoryFrame::Ptr observations, CObservation::Ptr observation) override {
    const bool done = Optimizer::updateState(action, observations, observation);
    nodes = this->m_graph->nodes;
    return done;
  }
};

std::string configuration() {
  const std::string path = (std::filesystem::path(::testing::TempDir()) / "holdfast_engine.ini").string();
  std::ofstream(path) << "[GeneralConfiguration]\nclass_verbosity = 4\nLC_min_nodeid_diff = 10\n"
                         "[VisualizationParameters]\nvisualize_map = false\n"
                         "[OptimizerParameters]\noptimization_distance = -1\noptimization_on_second_thread = false\nclass_verbosity = 4\n"
                         "max_iterations = 1000\ntau = 1e-3\n";
  return path;
}

template <class Optimizer>
Network::global_poses_t run(const Drive& drive, Recorded<Optimizer>& optimizer) {
  Nodes nodes(drive);
  Closures closures(drive);
  CGraphSlamEngine<Network> engine(configuration(), "", "", nullptr, &nodes, &closures, &optimizer);
  std::size_t entry = 0;
  for (int k = 0; k + 1 < kNodes; ++k) {
    auto odometry = mrpt::obs::CObservationOdometry::Create();
    odometry->timestamp = mrpt::Clock::fromDouble(1000.0 + k);
    CObservation::Ptr observation = odometry;
    engine.execGraphSlamStep(observation, entry);
    ++entry;
  }
  return optimizer.nodes;
}

double rmse(const Network::global_poses_t& nodes, const Drive& drive) {
  double sum = 0;
  for (int k = 0; k < kNodes; ++k) sum += std::pow((CPose2D(nodes.at(k)) - drive.truth[k]).norm(), 2);
  return std::sqrt(sum / kNodes);
}

/// MRPT's own measure of nodes.
double chi2(const Drive& drive, const Network::global_poses_t& nodes) {
  Network network;
  for (int k = 0; k + 1 < kNodes; ++k) network.insertEdge(k, k + 1, drive.odometry[k]);
  for (int k = 0; k < kNodes; ++k)
    for (const auto& [to, edge] : drive.closures[k]) network.insertEdge(to, k, edge);
  network.nodes = nodes;
  return network.chi2();
}

/// The largest difference of the nodes as seen from the root, which CLevMarqGSO moves along: in metres and radians.
double largest_difference(const Network::global_poses_t& a, const Network::global_poses_t& b) {
  double largest = 0;
  for (int k = 0; k < kNodes; ++k) {
    const CPose2D difference = (CPose2D(a.at(k)) - CPose2D(a.at(0))) - (CPose2D(b.at(k)) - CPose2D(b.at(0)));
    largest = std::max({largest, std::abs(difference.x()), std::abs(difference.y()), std::abs(difference.phi())});
  }
  return largest;
}

// optimize_graph_spa_levmarq steps along the gradient of Σ eᵀ Λ e, but takes a step only where Σ ‖e‖², without the information Λ, gets less
// (levmarq_impl.h, computeJacobiansAndErrors). Where Λ is the same multiple of the identity on every edge the two agree, and so do we.
TEST(MrptOptimizer, ReproducesLevMarqOnCleanData) {
  const Drive drive = make_drive(0, 0.02);  // as many radians as metres
  Recorded<optimizers::CLevMarqGSO<Network>> theirs;
  Recorded<HoldfastGSO<Network>> ours;
  ours.options.cost_tolerance = 1e-12;
  const auto expected = run(drive, theirs), found = run(drive, ours);
  std::cout << "clean data: " << largest_difference(expected, found) << " from CLevMarqGSO\n";
  EXPECT_LT(largest_difference(expected, found), 1e-4);
}

// Where they are not, it stops early, at a higher sum of its own.
TEST(MrptOptimizer, GoesLowerThanLevMarqWhereSigmasDiffer) {
  const Drive drive = make_drive(0);
  Recorded<optimizers::CLevMarqGSO<Network>> theirs;
  Recorded<HoldfastGSO<Network>> ours;
  ours.options.cost_tolerance = 1e-12;
  const auto expected = run(drive, theirs), found = run(drive, ours);
  const double their_chi2 = chi2(drive, expected), our_chi2 = chi2(drive, found);
  std::cout << "unequal sigmas: " << largest_difference(expected, found) << " from CLevMarqGSO; chi2 " << our_chi2 << ", CLevMarqGSO "
            << their_chi2 << '\n';
  EXPECT_LE(our_chi2, their_chi2 * (1 + 1e-9));
}

TEST(MrptOptimizer, BeatsLevMarqUnderFalseLoopClosures) {
  const Drive drive = make_drive(0.1);
  Recorded<optimizers::CLevMarqGSO<Network>> theirs;
  Recorded<HoldfastGSO<Network>> ours;
  ours.loss = Cauchy{2};
  const double their_error = rmse(run(drive, theirs), drive), our_error = rmse(run(drive, ours), drive);
  std::cout << "10 % false loop closures, rmse to truth: ours " << our_error << " m, CLevMarqGSO " << their_error << " m\n";
  EXPECT_LT(our_error, 0.2);
  EXPECT_LT(our_error, 0.5 * their_error);
  EXPECT_EQ(ours.answer.size(), static_cast<std::size_t>(kNodes));
}

TEST(MrptOptimizer, ReadsItsParametersFromTheConfiguration) {
  const std::string path = (std::filesystem::path(::testing::TempDir()) / "holdfast_parameters.ini").string();
  std::ofstream(path) << "[OptimizerParameters]\nholdfast_backend = nesterov\nholdfast_loss = cauchy:3\n";
  HoldfastGSO<Network> optimizer;
  optimizer.loadParams(path);
  EXPECT_EQ(optimizer.backend, "nesterov");
  EXPECT_EQ(optimizer.loss, Loss(Cauchy{3}));
  std::string report;
  optimizer.getDescriptiveReport(&report);
  EXPECT_THAT(report, ::testing::HasSubstr("cauchy:3"));
}

// ---- mrpt-common's circle, from its noisy start

TEST(MrptCircle, AtLeastAsCloseToTruthAsMrptsOwnOptimizer) {
  const std::string stem = "/usr/share/mrpt/datasets/graph_2d_circle_50nodes";
  if (!std::filesystem::is_regular_file(stem + ".graph")) GTEST_SKIP() << "mrpt-common is not installed: there is no " << stem << ".graph";
  const Problem file =
      make_problem(read_toro(stem + ".graph"));  // MRPT 2.5.8 takes EDGE2's information in g2o's order, which makes it indefinite
  const Network noisy = to_mrpt<Network>(file.graph, file.start);
  Network truth;
  truth.loadFromTextFile(stem + "_groundtruth.graph", false);
  const auto error = [&](const Network& network) {
    double sum = 0;
    for (const auto& [id, pose] : network.nodes) sum += std::pow((CPose2D(pose) - CPose2D(truth.nodes.at(id))).norm(), 2);
    return std::sqrt(sum / static_cast<double>(network.nodes.size()));
  };
  const auto seconds = [](const auto& call) {
    double least = std::numeric_limits<double>::infinity();
    for (int repeat = 0; repeat < 5; ++repeat) {
      const auto begin = std::chrono::steady_clock::now();
      call();
      least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    return least;
  };
  Network theirs, ours;
  const double their_seconds = seconds([&] {
    theirs = noisy;
    TResultInfoSpaLevMarq info;
    optimize_graph_spa_levmarq(theirs, info);
  });
  const double our_seconds = seconds([&] {  // conversions and all
    ours = noisy;
    Problem problem = from_mrpt(ours);
    ASSERT_TRUE(make_backend("irls")->solve(problem.graph, problem.start).usable());
    write_back(problem.start, ours);
  });
  std::cout << "circle: rmse to truth " << error(noisy) << " m -> ours " << error(ours) << " m in " << our_seconds << " s, MRPT "
            << error(theirs) << " m in " << their_seconds << " s; ratio " << their_seconds / our_seconds << '\n';
  EXPECT_LE(error(ours), error(theirs) * (1 + 1e-6));
}

}  // namespace
}  // namespace holdfast::testing
