// MRPT's poses, Gaussians and networks as ours, and back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mrpt/graphs/CNetworkOfPoses.h>

#include <holdfast/adapters/mrpt/graph.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/testing.hpp>

#include "tests/adapters/data_files.hpp"

namespace holdfast::testing {
namespace {

using namespace mrpt::poses;
using namespace mrpt::graphs;
using ::testing::HasSubstr;
constexpr Agent A('A'), X('x');

// ---- values

TEST(MrptValues, PosesGoInAndComeOut) {
  Values values;
  const CPose3D pose(1, 2, 3, 0.4, -0.5, 0.6);
  values.insert(A(3), pose);
  values.insert(A(4), CPose2D(1, 2, 3.1));
  values.insert(A(5), mrpt::math::TPoint3D(7, 8, 9));
  values.insert(A(6), CPoint2D(5, 6));
  EXPECT_LT((values.at<CPose3D>(A(3)) - pose).norm(), 1e-15);
  EXPECT_NEAR(values.at<CPose3D>(A(3)).pitch(), -0.5, 1e-15);
  EXPECT_NEAR(values.at<CPose3DQuat>(A(3)).z(), 3, 1e-15);
  EXPECT_NEAR(values.at<mrpt::math::TPose2D>(A(4)).phi, 3.1, 1e-15);
  EXPECT_EQ(values.at<CPoint3D>(A(5)).z(), 9);
  EXPECT_EQ(values.at<Point2>(A(6)).value, Vector<2>(5, 6));
  EXPECT_THROW(values.at<CPose3D>(A(4)), BadType);
  values.update(A(3), CPose3D());
  EXPECT_LT(values.at<Pose3>(A(3)).p.norm(), 1e-15);
}

TEST(MrptValues, TheRotationIsTheSame) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 100; ++i) {
    const Pose3 pose = random_variable<Pose3>(rng);
    const CPose3D theirs = StandsFor<CPose3D>::theirs(pose);
    const Vector<3> p = random_vector<3>(rng);
    mrpt::math::TPoint3D in_world;
    theirs.composePoint(mrpt::math::TPoint3D(p[0], p[1], p[2]), in_world);
    EXPECT_LT((pose.p + pose.to_world(p) - Vector<3>(in_world.x, in_world.y, in_world.z)).norm(), 1e-13);
    EXPECT_LT(pose.local(StandsFor<CPose3D>::ours(theirs)).norm(), 1e-14);
  }
}

// ---- Gaussians

Vector<3> coordinates(const Pose2& p) { return {p.p[0], p.p[1], p.angle()}; }
Vector<6> coordinates(const Pose3& p) {
  const CPose3D c = StandsFor<CPose3D>::theirs(p);
  Vector<6> v;
  v << c.x(), c.y(), c.z(), c.yaw(), c.pitch(), c.roll();
  return v;
}

template <class V>
void expect_coordinate_jacobian() {
  std::mt19937_64 rng(2);
  for (int i = 0; i < 100; ++i) {
    V measured = random_variable<V>(rng);
    if constexpr (V::dim == 6)
      if (std::abs(std::cos(StandsFor<CPose3D>::theirs(measured).pitch())) < 0.1) continue;
    Matrix<V::dim, V::dim> numeric;
    for (int c = 0; c < V::dim; ++c) {
      const Vector<V::dim> step = 1e-6 * Vector<V::dim>::Unit(c);
      Vector<V::dim> d = coordinates(measured * V().retract(step)) - coordinates(measured * V().retract(-step));
      for (int k = V::space_dim; k < V::dim; ++k) d[k] = wrap_angle(d[k]);
      numeric.col(c) = d / 2e-6;
    }
    EXPECT_LT((numeric - mrpt_coordinates(measured)).norm(), 1e-6);
  }
}

TEST(MrptGaussians, CoordinatesHaveTheJacobianStated) {
  expect_coordinate_jacobian<Pose2>();
  expect_coordinate_jacobian<Pose3>();
}

/// Near the mean, half the squared Mahalanobis distance in MRPT's own coordinates is our cost, at second order.
TEST(MrptGaussians, CostIsTheirMahalanobisDistanceNearTheMean) {
  std::mt19937_64 rng(3);
  for (int i = 0; i < 20; ++i) {
    CPose3DPDFGaussianInf pdf;
    pdf.mean = CPose3D(1, 2, 3, uniform(rng, -3, 3), uniform(rng, -1.2, 1.2), uniform(rng, -3, 3));
    pdf.cov_inv = mrpt::math::CMatrixDouble66(random_covariance<6>(rng));
    const auto between = mrpt_between(pdf);
    const auto prior = mrpt_prior(pdf);
    const Vector<6> step = random_vector<6>(rng, 1e-5);
    const Pose3 a = random_variable<Pose3>(rng), moved = between.measured * Pose3().retract(step);
    const Vector<6> d = coordinates(moved) - coordinates(between.measured);
    const double theirs = d.dot(pdf.cov_inv.asEigen() * d);
    EXPECT_NEAR(between(a, a * moved).squaredNorm() / theirs, 1, 1e-3);
    EXPECT_NEAR(prior(moved).squaredNorm() / theirs, 1, 1e-3);
  }
}

TEST(MrptGaussians, CovarianceAndInformationAgree) {
  CPosePDFGaussian covariance;
  covariance.mean = CPose2D(1, 2, 0.7);
  std::mt19937_64 rng(4);
  covariance.cov = mrpt::math::CMatrixDouble33(random_covariance<3>(rng));
  CPosePDFGaussianInf information;
  information.copyFrom(covariance);
  EXPECT_LT((mrpt_between(covariance).sqrt_information - mrpt_between(information).sqrt_information).norm(), 1e-12);
}

TEST(MrptGaussians, WithoutYawAndRollOfItsOwnAPoseIsRefused) {
  CPose3DPDFGaussianInf pdf;
  pdf.mean = CPose3D(0, 0, 0, 0.3, kPi / 2, 0);
  pdf.cov_inv.setIdentity();
  EXPECT_THROW(mrpt_between(pdf), BadNumber);
}

TEST(MrptGaussians, OfNoInformationSayNothing) {
  CPosePDFGaussianInf empty;  // MRPT's default
  empty.cov_inv.setZero();
  EXPECT_EQ(mrpt_between(empty)(Pose2(0, 0, 0), Pose2(1, 2, 3)).norm(), 0);
}

// ---- networks

CNetworkOfPoses2DInf small_network() {
  CNetworkOfPoses2DInf network;
  std::mt19937_64 rng(5);
  for (const TNodeID id : {3, 7, 9, 20}) network.nodes[id] = CPose2D(id, uniform(rng, -1, 1), uniform(rng, -3, 3));
  for (const auto& [a, b] : {std::pair(3, 7), std::pair(7, 9), std::pair(3, 7), std::pair(7, 3), std::pair(9, 20)}) {
    CPosePDFGaussianInf edge;
    edge.mean = CPose2D(uniform(rng, -2, 2), uniform(rng, -2, 2), uniform(rng, -3, 3));
    edge.cov_inv = mrpt::math::CMatrixDouble33(random_covariance<3>(rng));
    network.insertEdge(a, b, edge);
  }
  network.root = 7;
  return network;
}

template <class Network>
void expect_same(const Network& a, const Network& b) {
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  EXPECT_EQ(a.root, b.root);
  for (const auto& [id, pose] : a.nodes) EXPECT_LT((pose - b.nodes.at(id)).norm(), 1e-12) << id;
  ASSERT_EQ(a.edges.size(), b.edges.size());
  for (auto x = a.edges.cbegin(), y = b.edges.cbegin(); x != a.edges.cend(); ++x, ++y) {
    EXPECT_EQ(x->first, y->first);
    EXPECT_LT((x->second.mean - y->second.mean).norm(), 1e-12);
    const auto I = x->second.cov_inv.asEigen();
    EXPECT_LT((I - y->second.cov_inv.asEigen()).norm(), 1e-9 * I.norm());
  }
}

TEST(MrptNetwork, ThereAndBackIsTheSameWithParallelEdgesAndGapsInIds) {
  const CNetworkOfPoses2DInf network = small_network();
  const Problem problem = from_mrpt(network);
  EXPECT_EQ(problem.graph.size(), 5u);
  EXPECT_TRUE(problem.graph.is_fixed(X(7)));
  expect_same(network, to_mrpt<CNetworkOfPoses2DInf>(problem.graph, problem.start));
}

TEST(MrptNetwork, IdsOfManyRobotsKeepThemApart) {
  const CNetworkOfPoses2DInf plain = small_network();
  const auto of_robot = [](TNodeID id) { return (TNodeID{'A'} << 48) | id; };
  CNetworkOfPoses2DInf network;
  for (const auto& [id, pose] : plain.nodes) network.nodes[of_robot(id)] = pose;
  for (const auto& [ids, edge] : plain.edges) network.insertEdge(of_robot(ids.first), of_robot(ids.second), edge);
  network.root = of_robot(plain.root);
  const Problem problem = from_mrpt(network);
  for (const Key key : problem.start.keys()) EXPECT_EQ(key.agent(), Agent('\0', 'A' << 16)) << key;
  expect_same(network, to_mrpt<CNetworkOfPoses2DInf>(problem.graph, problem.start));
}

TEST(MrptNetwork, OneOfCovariancesToo) {
  CNetworkOfPoses3DCov network;
  std::mt19937_64 rng(6);
  for (const TNodeID id : {0, 1, 2}) network.nodes[id] = CPose3D(id, 0, 0, 0.3 * id, 0.2, -0.1 * id);
  for (int i = 0; i < 2; ++i) {
    CPose3DPDFGaussian edge;
    edge.mean = CPose3D(1, 0.1, 0.2, 0.3, -0.4, 0.5);
    edge.cov = mrpt::math::CMatrixDouble66(random_covariance<6>(rng));
    network.insertEdge(i, i + 1, edge);
  }
  const Problem problem = from_mrpt(network);
  const auto back = to_mrpt<CNetworkOfPoses3DCov>(problem.graph, problem.start);
  for (auto x = network.edges.cbegin(), y = back.edges.cbegin(); x != network.edges.cend(); ++x, ++y)
    EXPECT_LT((x->second.cov.asEigen() - y->second.cov.asEigen()).norm(), 1e-10);
}

TEST(MrptNetwork, InverseEdgesMeasureTheOtherWayRound) {
  CNetworkOfPoses2D network;
  network.nodes[0] = CPose2D(0, 0, 0.2);
  network.nodes[1] = CPose2D(1, 2, 0.5);
  network.edges_store_inverse_poses = true;
  network.insertEdge(0, 1, CPose2D(network.nodes[0]) - CPose2D(network.nodes[1]));
  const Problem problem = from_mrpt(network);
  EXPECT_LT(problem.graph.cost(problem.start), 1e-28);
}

TEST(MrptNetwork, WritingBackKeepsAnnotations) {
  struct Named : mrpt::graphs::detail::TNodeAnnotationsEmpty {
    std::string robot;
  };
  CNetworkOfPoses<CPosePDFGaussianInf, mrpt::containers::map_traits_stdmap, Named> network;
  for (const TNodeID id : {0, 1}) network.nodes[id].robot = "robot " + std::to_string(id);
  CPosePDFGaussianInf edge;
  edge.mean = CPose2D(1, 0, 0.1);
  edge.cov_inv.setIdentity();
  network.insertEdge(0, 1, edge);
  Problem problem = from_mrpt(network);
  ASSERT_TRUE(make_backend("irls")->solve(problem.graph, problem.start).usable());
  write_back(problem.start, network);
  EXPECT_NEAR(network.nodes[1].x(), 1, 1e-9);
  EXPECT_EQ(network.nodes[1].robot, "robot 1");
}

template <class Fn>
std::string message_of(const Fn& fn) {
  try {
    fn();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(MrptNetwork, AnInformationThatIsNoneIsNamedByItsEdge) {
  mrpt::graphs::CNetworkOfPoses2DInf network;
  network.nodes[4] = network.nodes[7] = mrpt::poses::CPose2D();
  mrpt::poses::CPosePDFGaussianInf edge;
  edge.cov_inv.setIdentity();
  edge.cov_inv(0, 0) = -1;
  network.insertEdge(4, 7, edge);
  try {
    from_mrpt(network);
    FAIL() << "it was taken";
  } catch (const BadNumber& error) {
    EXPECT_THAT(error.what(), ::testing::AllOf(::testing::HasSubstr("edge 4 -> 7"), ::testing::HasSubstr("read_toro")));
  }
}

TEST(MrptNetwork, WhatItCannotHoldIsNamed) {
  Problem problem = from_mrpt(small_network());
  const auto convert = [&] { to_mrpt<CNetworkOfPoses2DInf>(problem.graph, problem.start); };
  const FactorId prior = problem.graph.add(Prior<Pose2>::from_sigmas(Pose2(), Vector<3>(1, 1, 1)), {X(9)});
  EXPECT_THAT(message_of(convert), HasSubstr("Prior(x9)"));
  problem.graph.remove(prior);
  const FactorId robust = problem.graph.add(Between<Pose2>::from_sigmas(Pose2(), Vector<3>(1, 1, 1)), {X(3), X(20)}, Cauchy{2});
  EXPECT_THAT(message_of(convert), HasSubstr("cauchy:2"));
  problem.graph.remove(robust);
  problem.graph.fix(X(20));
  EXPECT_THAT(message_of(convert), HasSubstr("2 poses are fixed"));
  problem.graph.unfix(X(20));
  problem.start.insert(Key('L', 1), Point2(1, 1));
  EXPECT_THAT(message_of(convert), HasSubstr("L1"));
  CNetworkOfPoses2DInf torn = small_network();
  torn.nodes.erase(20);
  EXPECT_THAT(message_of([&] { from_mrpt(torn); }), HasSubstr("no node 20"));
}

// ---- files: what MRPT reads and what we read are the same graph

template <class Network>
void expect_round_trip(const Problem& problem) {
  const auto network = to_mrpt<Network>(problem.graph, problem.start);
  const Problem back = from_mrpt(network);
  EXPECT_EQ(back.graph.size(), problem.graph.size());
  EXPECT_EQ(back.graph.fixed(), problem.graph.fixed());
  EXPECT_EQ(back.start.keys(), problem.start.keys());
  const double cost = problem.graph.cost(problem.start);
  EXPECT_NEAR(back.graph.cost(back.start), cost, 1e-9 * cost);
  EXPECT_NEAR(back.graph.cost(problem.start), cost, 1e-9 * cost);  // the edges alone
  expect_same(network, to_mrpt<Network>(back.graph, back.start));
}

TEST(MrptNetwork, EveryPoseGraphFileGoesThereAndBack) {
  int read_files = 0;
  for (const std::string& file : data_files({".g2o", ".graph"})) {
    SCOPED_TRACE(file);
    const Problem problem = make_problem(read_dataset(file));
    const Key first = problem.start.keys().front();
    if (problem.start.contains<Pose2>(first))
      expect_round_trip<CNetworkOfPoses2DInf>(problem);
    else
      expect_round_trip<CNetworkOfPoses3DInf>(problem);
    ++read_files;
  }
  if (read_files == 0) GTEST_SKIP() << kNoFiles;
}

}  // namespace
}  // namespace holdfast::testing
