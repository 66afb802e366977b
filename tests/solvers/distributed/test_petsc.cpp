// "petsc" in 1, 2 and 4 processes ends where irls does.
#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/solvers/distributed/petsc.hpp>

#include "tests/solvers/distributed/parts.hpp"

namespace holdfast::testing {
namespace {

/// Solved by irls here, by one process here, and by all together.
void expect_same_cost(const Whole& whole, const OfPetsc& of_petsc = {}) {
  const Communicator all;
  Values by_irls = whole.values, by_one = whole.values;
  const Summary irls = solve("irls", whole.graph, by_irls, tight());
  const Summary one = Petsc(tight(), of_petsc).solve(whole.graph, by_one);
  DistributedGraph graph = part_of(whole, all);
  Petsc petsc(tight(), of_petsc);
  const Summary many = petsc.solve(graph);
  ASSERT_EQ(irls.termination, Termination::converged) << irls;
  EXPECT_EQ(one.termination, Termination::converged) << one;
  EXPECT_EQ(many.termination, Termination::converged) << many;
  EXPECT_NEAR(one.cost, irls.cost, 1e-8 * irls.cost);
  EXPECT_NEAR(many.cost, one.cost, 1e-9 * one.cost);
  EXPECT_NEAR(graph.cost(), many.cost, 1e-12 * many.cost);
  EXPECT_EQ(many.is_convex, irls.is_convex);
  if (all.rank() == 0) std::cout << "  " << petsc.report().solver << ", " << many << std::endl;
}

TEST(Petsc, ARangeNetwork) { expect_same_cost(range_network(400, 3)); }
TEST(Petsc, APoseGraphWithARobustLoss) { expect_same_cost(laps(300, 4)); }

TEST(Petsc, EveryOptionOfPetscReachesIt) {
  Whole whole = range_network(300, 5);  // every node knows roughly where it is: iterative solvers are at ease
  for (Key key : whole.values.keys()) whole.graph.add(Prior<Point2>::from_sigmas(whole.values.at<Point2>(key), Vector<2>(3, 3)), {key});
  for (const char* text :
       {"-ksp_type cg -pc_type asm -pc_asm_type basic -sub_pc_type cholesky", "-ksp_type gmres -pc_type bjacobi -sub_pc_type cholesky"}) {
    SCOPED_TRACE(text);
    OfPetsc of_petsc;
    of_petsc.text = text;
    expect_same_cost(whole, of_petsc);
  }
}

TEST(Petsc, KnowsTheBlockSize) {
  const Communicator all;
  DistributedGraph graph = part_of(laps(100, 6), all);
  Petsc petsc;
  petsc.solve(graph);
  EXPECT_EQ(petsc.report().block_size, 3);
  EXPECT_EQ(petsc.report().scalars, 300);
}

TEST(Petsc, AllStopWhereOneWantsTo) {
  const Communicator all;
  DistributedGraph graph = part_of(range_network(200, 7), all);
  Options options = tight();
  if (all.rank() == all.size() - 1) options.progress = [](const Iteration& i) { return i.number < 2; };
  const Summary summary = Petsc(options).solve(graph);
  EXPECT_EQ(summary.termination, Termination::stopped);
  EXPECT_EQ(summary.iterations, 2);
  EXPECT_LT(summary.cost, summary.cost_first);
}

TEST(Petsc, AfterAFailureTheStartIsThere) {
  const Communicator all;
  Whole whole = range_network(100, 8);
  const Key last = whole.values.keys().back();
  whole.values.update(last, Point2(NAN, 0.0));
  DistributedGraph graph = part_of(whole, all);
  const Summary summary = Petsc().solve(graph);
  EXPECT_EQ(summary.termination, Termination::failed);
  if (graph.is_own(last)) {
    EXPECT_THAT(summary.culprit, ::testing::HasSubstr(last.str()));
  }
  for (Key key : graph.values().keys())
    if (key != last) {
      EXPECT_EQ(graph.values().at<Point2>(key).position(), whole.values.at<Point2>(key).position()) << key;
    }
}

TEST(Petsc, SaysWhatIsNotForManyProcesses) {
  const Communicator all;
  DistributedGraph graph = part_of(range_network(100, 9), all);
  Options options;
  options.second_order = true;
  if (all.size() > 1) {
    EXPECT_THROW(Petsc(options).solve(graph), BadOption);
  }
  OfPetsc of_petsc;
  of_petsc.tolerance = 2;
  EXPECT_THROW(Petsc({}, of_petsc).solve(graph), BadOption);
}

class PetscOnData : public ::testing::TestWithParam<const char*> {};

TEST_P(PetscOnData, EndsAtTheCostOfIrls) {
  const char* chosen = std::getenv("HOLDFAST_DATA");
  const std::string path = (chosen != nullptr ? std::string(chosen) : std::string(HOLDFAST_SOURCE_DIR) + "/../shared/data") + GetParam();
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there; set HOLDFAST_DATA";
  Problem problem = make_problem(read_dataset(path), {Squared{}, ProblemOptions::Start::chordal, 0});
  expect_same_cost({std::move(problem.graph), std::move(problem.start)});
}
INSTANTIATE_TEST_SUITE_P(Files, PetscOnData, ::testing::Values("/pose_graph/M3500.g2o", "/pose_graph/sphere2500.g2o"),
                         [](const auto& of) { return std::filesystem::path(of.param).stem().string(); });

}  // namespace
}  // namespace holdfast::testing
