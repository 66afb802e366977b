#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/solvers/certificate.hpp>
#include <holdfast/solvers/internal/pose_minorant.hpp>
#include <holdfast/solvers/irls/irls.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), L('L');

template <class V>
V random_pose(std::mt19937_64& rng, double length, double turn) {
  return V{}.retract(
      (Vector<V::dim>() << random_vector<V::space_dim>(rng, length), random_vector<rotation_dim<V::space_dim>>(rng, turn)).finished());
}

/// Any information, with cross blocks; of rank N − 1 now and then.
template <int N>
Matrix<N, N> random_information(std::mt19937_64& rng) {
  const Eigen::Matrix<double, N, N> B = Eigen::Matrix<double, N, N>::NullaryExpr([&] { return random_vector<1>(rng, 1)[0]; });
  Vector<N> spread;
  for (int i = 0; i < N; ++i) spread[i] = std::exp(random_vector<1>(rng, 1)[0]);
  if (rng() % 8 == 0) spread[0] = 0;
  return B * spread.asDiagonal() * B.transpose();
}

// ---- the quadratic function below the cost

template <class V>
class MinorantOf : public ::testing::Test {};
using PoseTypes = ::testing::Types<Pose2, Pose3>;
TYPED_TEST_SUITE(MinorantOf, PoseTypes);

template <class V>
double cost_of(const MeasuredPose<V>& measured, const V& a, const V& b) {
  const Between<V> factor = Between<V>::from_information(measured.pose, measured.information);
  return 0.5 * factor(a, b).squaredNorm();
}

TYPED_TEST(MinorantOf, LiesBelowTheCostAndTouchesIt) {
  using V = TypeParam;
  std::mt19937_64 rng(7);
  for (int trial = 0; trial < 300; ++trial) {
    const double error = std::vector<double>{0, 1e-6, 0.05, 0.3, 0.6}[trial % 5];
    MeasuredPose<V> measured{random_pose<V>(rng, 2, 1.5), random_information<V::dim>(rng)};
    if (trial % 3 == 0) measured.information = Matrix<V::dim, V::dim>::Identity() * 4;
    const V a = random_pose<V>(rng, 3, 2), b = a * measured.pose * random_pose<V>(rng, error, error);
    const auto minorant = holdfast::detail::minorant_at<V>(measured, 1, a, b);
    const double here = cost_of<V>(measured, a, b), scale = measured.information.norm() * (1 + here);
    const Vector<V::dim> off = (measured.pose.inverse() * (a.inverse() * b)).local(V{});
    const double angle = off.template tail<V::dim - V::space_dim>().norm();
    if (angle < 1.4) {
      EXPECT_NEAR(minorant(a, b), here, 1e-9 * scale);
      for (int k = 0; k < V::dim; ++k) {  // the same gradient, by central differences
        constexpr double h = 1e-5;
        const Vector<V::dim> d = h * Vector<V::dim>::Unit(k);
        EXPECT_NEAR(minorant(a, b.retract(d)) - minorant(a, b.retract(-d)),
                    cost_of<V>(measured, a, b.retract(d)) - cost_of<V>(measured, a, b.retract(-d)), 2e-9 * scale);
        EXPECT_NEAR(minorant(a.retract(d), b) - minorant(a.retract(-d), b),
                    cost_of<V>(measured, a.retract(d), b) - cost_of<V>(measured, a.retract(-d), b), 2e-9 * scale);
      }
    }
    for (int far = 0; far < 200; ++far) {
      const double reach = std::pow(10.0, -2 + far % 4);
      const V moved = b.retract((Vector<V::dim>() << random_vector<V::space_dim>(rng, reach),
                                 random_vector<rotation_dim<V::space_dim>>(rng, std::min(reach, 2.0)))
                                    .finished());
      ASSERT_LE(minorant(a, moved), cost_of<V>(measured, a, moved) + 1e-9 * (scale + cost_of<V>(measured, a, moved)))
          << "trial " << trial << ", angle " << angle;
    }
  }
}

TYPED_TEST(MinorantOf, AtLargeAnglesLiesBelow) {
  using V = TypeParam;
  std::mt19937_64 rng(8);
  for (int trial = 0; trial < 300; ++trial) {
    const MeasuredPose<V> measured{random_pose<V>(rng, 2, 1.5), random_information<V::dim>(rng)};
    const V a = random_pose<V>(rng, 3, 2), b = random_pose<V>(rng, 3, 2);
    const auto minorant = holdfast::detail::minorant_at<V>(measured, 1, a, b);
    for (int far = 0; far < 100; ++far) {
      const V moved = random_pose<V>(rng, 5, 3);
      const double cost = cost_of<V>(measured, a, moved);
      ASSERT_LE(minorant(a, moved), cost + 1e-9 * (measured.information.norm() + cost));
    }
  }
}

// ---- graphs

/// A ring of poses with chords; information isotropic or not.
template <class V>
SmallProblem ring(std::uint64_t seed, int poses, double noise, bool isotropic) {
  constexpr int turns = rotation_dim<V::space_dim>;
  std::mt19937_64 rng(seed);
  SmallProblem problem;
  V x;
  Vector<V::dim> step = Vector<V::dim>::Zero();
  step[0] = 1;
  step[V::dim - 1] = 2 * kPi / poses;
  for (int i = 0; i < poses; ++i, x = x * V{}.retract(step)) problem.truth.insert(A(i), x);
  const auto tie = [&](int i, int j) {
    Matrix<V::dim, V::dim> information = Matrix<V::dim, V::dim>::Identity() / (noise * noise);
    if (!isotropic) {
      Vector<V::dim> scales;
      for (int k = 0; k < V::dim; ++k) scales[k] = k < V::space_dim ? 1 + 0.7 * k : 2 + 0.5 * k;
      information = scales.asDiagonal() * information;
      information(0, V::dim - 1) = information(V::dim - 1, 0) = 0.3 / (noise * noise);
    }
    const V exact = problem.truth.at<V>(A(i)).inverse() * problem.truth.at<V>(A(j));
    const V measured =
        exact * V{}.retract((Vector<V::dim>() << random_vector<V::space_dim>(rng, noise), random_vector<turns>(rng, noise)).finished());
    problem.graph.add(Between<V>::from_information(measured, information), {A(i), A(j)});
  };
  for (int i = 0; i < poses; ++i) tie(i, (i + 1) % poses);
  for (int i = 0; i + poses / 3 < poses; i += 3) tie(i, i + poses / 3);
  problem.graph.fix(A(0));
  problem.start = problem.truth;
  return problem;
}

template <class V>
class CertificateOf : public ::testing::Test {};
TYPED_TEST_SUITE(CertificateOf, PoseTypes);

TYPED_TEST(CertificateOf, TheMinimumOfARing) {
  for (bool isotropic : {true, false}) {
    SmallProblem problem = ring<TypeParam>(3, 30, 0.05, isotropic);
    solve("irls", problem.graph, problem.start);
    const Certificate certificate = certify(problem.graph, problem.start);
    EXPECT_EQ(certificate.verdict, Certificate::Verdict::global_minimum) << certificate.str();
    EXPECT_LE(certificate.relative_gap(), 1e-10) << certificate.str();
    EXPECT_EQ(certificate.is_isotropic, isotropic);
    EXPECT_EQ(certificate.factorizations, 1);
    EXPECT_EQ(certificate.left_out, 0u);
    EXPECT_NEAR(certificate.cost, problem.graph.cost(problem.start), 1e-12 * certificate.cost);
  }
}

TYPED_TEST(CertificateOf, IsTheSameWithoutAFixedPoseAndWithAPriorThatIsMet) {
  SmallProblem problem = ring<TypeParam>(4, 20, 0.05, true);
  solve("irls", problem.graph, problem.start);
  problem.graph.unfix(A(0));
  EXPECT_TRUE(certify(problem.graph, problem.start).is_global());
  problem.graph.add(Prior<TypeParam>::from_sigmas(problem.start.template at<TypeParam>(A(0)), Vector<TypeParam::dim>::Constant(0.1)),
                    {A(0)});
  const Certificate certificate = certify(problem.graph, problem.start);
  EXPECT_TRUE(certificate.is_global()) << certificate.str();
  EXPECT_EQ(certificate.left_out, 1u);
  EXPECT_EQ(certificate.left_out_cost, 0);
}

// No values have a cost below the bound: wherever it is asked for, the best that many starts reach is above it.
TYPED_TEST(CertificateOf, BoundHoldsWhereverItIsAsked) {
  std::mt19937_64 rng(11);
  for (int trial = 0; trial < 12; ++trial) {
    SmallProblem problem = ring<TypeParam>(trial, 9, trial % 2 == 0 ? 0.1 : 0.5, trial % 3 != 0);
    double best = std::numeric_limits<double>::infinity(), highest_bound = 0;
    for (int start = 0; start < 8; ++start) {
      Values values = start == 0 ? problem.truth : perturbed(problem.graph, problem.truth, 0.4 * start, rng);
      if (start % 2 == 0) solve("irls", problem.graph, values);
      const Certificate certificate = certify(problem.graph, values);
      highest_bound = std::max(highest_bound, certificate.bound);
      best = std::min(best, problem.graph.cost(values));
      EXPECT_LE(certificate.bound, certificate.cost);
    }
    EXPECT_LE(highest_bound, best * (1 + 1e-9)) << "trial " << trial;
  }
}

// A ring whose start winds the wrong way round ends in a minimum that is not the global one.
TEST(Certificate, RefusesAMinimumThatIsNotGlobal) {
  SmallProblem problem;
  constexpr int kPoses = 20;
  for (int i = 0; i < kPoses; ++i) {
    problem.graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0, 0.0), Vector<3>(0.1, 0.1, 0.1)), {A(i), A((i + 1) % kPoses)});
    problem.truth.insert(A(i), Pose2(0, 0, 0.0));
    problem.start.insert(A(i), Pose2(Vector<2>(std::sin(2 * kPi * i / kPoses) * 3, 3 - std::cos(2 * kPi * i / kPoses) * 3),
                                     Vector<2>(std::cos(2 * kPi * i / kPoses), std::sin(2 * kPi * i / kPoses))));
  }
  problem.graph.fix(A(0));
  Values straight = problem.truth, wound = problem.start;
  solve("irls", problem.graph, straight);
  IrlsOptions no_restart;
  no_restart.restart = false;
  Irls irls(to_the_bottom(), no_restart);
  irls.solve(problem.graph, wound);
  const Values& best = problem.graph.cost(straight) < problem.graph.cost(wound) ? straight : wound;
  const Values& other = &best == &straight ? wound : straight;
  ASSERT_GT(problem.graph.cost(other), 1.01 * problem.graph.cost(best));
  const Certificate refused = certify(problem.graph, other);
  EXPECT_EQ(refused.verdict, Certificate::Verdict::not_certified) << refused.str();
  EXPECT_FALSE(refused.positive_definite);
  EXPECT_GT(refused.eta, 0);
  EXPECT_LE(refused.bound, problem.graph.cost(best));
}

// Directions a thousand times apart: where the graph's own bound fails, the chordal cost with isotropic weights is asked.
TEST(Certificate, AsksTheChordalCostWhereItsOwnBoundFails) {
  int asked = 0, yes = 0;
  for (int seed = 0; seed < 10; ++seed) {
    SmallProblem problem = ring<Pose2>(static_cast<std::uint64_t>(seed), 30, 0.03 * (1 + seed), true);
    Graph stretched;
    problem.graph.for_each_batch<Between<Pose2>>([&](const Batch<Between<Pose2>>& batch) {
      for (int i = 0; i < batch.size(); ++i) {
        Between<Pose2> factor = batch.factors()[i];
        factor.sqrt_information.row(0) *= 10;
        stretched.add(factor, {batch.keys(i)[0], batch.keys(i)[1]});
      }
    });
    stretched.fix(A(0));
    solve("irls", stretched, problem.start);
    const Certificate certificate = certify(stretched, problem.start);
    EXPECT_LE(certificate.bound, certificate.cost);
    if (certificate.positive_definite) continue;
    ++asked;
    EXPECT_LE(certificate.chordal_bound, certificate.chordal_cost * (1 + 1e-12)) << certificate.str();
    EXPECT_GT(certificate.chordal_turn, 0) << certificate.str();
    EXPECT_GT(certificate.bound, 0) << certificate.str();
    if (certificate.verdict == Certificate::Verdict::chordal_minimum) ++yes;
    EXPECT_FALSE(certificate.is_global());
  }
  EXPECT_GT(asked, 0);
  EXPECT_GT(yes, 0);
}

TEST(Certificate, SaysHowFarAnAnswerIsThatHasNotArrived) {
  SmallProblem problem = ring<Pose2>(5, 30, 0.05, true);
  Values minimum = problem.start;
  solve("irls", problem.graph, minimum);
  std::mt19937_64 rng(1);
  const Values near = perturbed(problem.graph, minimum, 1e-3, rng);
  const Certificate certificate = certify(problem.graph, near);
  EXPECT_EQ(certificate.verdict, Certificate::Verdict::not_certified);
  EXPECT_TRUE(certificate.positive_definite);
  EXPECT_GT(certificate.relative_gap(), 1e-7);
  EXPECT_LE(certificate.bound, problem.graph.cost(minimum));
  EXPECT_GT(certificate.bound, 0.5 * problem.graph.cost(minimum));
}

TEST(Certificate, CountsWhatItLeavesOut) {
  const SmallProblem problem = slam<Pose2>(3, 12, 0.02, Huber{2});
  Values values = problem.start;
  solve("irls", problem.graph, values);
  const Certificate certificate = certify(problem.graph, values);
  EXPECT_EQ(certificate.terms, 11u);
  EXPECT_EQ(certificate.left_out, problem.graph.size() - 11);
  EXPECT_NE(certificate.left_out_first, "");
  EXPECT_GT(certificate.left_out_cost, 0);
  EXPECT_LE(certificate.bound, certificate.cost);
}

TEST(Certificate, OfPositionsAndRangesIsTheConvexRelaxation) {
  const SmallProblem problem = range_balls<Point2>(2, 8, Huber{2});
  Values values = problem.start;
  solve("irls", problem.graph, values);
  const Certificate certificate = certify(problem.graph, values, {1e-6, true, true});
  EXPECT_NEAR(certificate.relaxation, certificate.cost, 1e-6 * certificate.cost) << certificate.str();  // balls are their own relaxation
  EXPECT_TRUE(certificate.is_global()) << certificate.str();

  Graph ranges;  // three anchors in a line: two mirror answers, and a range that fits neither
  Values plane;
  for (int i = 0; i < 3; ++i) {
    plane.insert(L(i), Point2(4.0 * i, 0));
    ranges.fix(L(i));
    ranges.add(Range<Point2, Point2>{i == 1 ? 2.0 : 5.0, 0.1}, {L(i), A(0)});
  }
  plane.insert(A(0), Point2(4, 2));
  solve("irls", ranges, plane);
  const Certificate loose = certify(ranges, plane);
  EXPECT_EQ(loose.verdict, Certificate::Verdict::not_certified);
  EXPECT_TRUE(std::isfinite(loose.relaxation));
  EXPECT_LE(loose.bound, loose.cost);
}

TEST(Certificate, NamesWhatIsWrong) {
  SmallProblem problem = ring<Pose2>(1, 6, 0.1, true);
  EXPECT_THROW(certify(problem.graph, problem.start, {0, true, true}), BadOption);
  EXPECT_THROW(certify(Graph(), problem.start), BadProblem);
  EXPECT_THROW(certify(problem.graph, Values()), BadKey);
  problem.start.update(A(2), Pose2(NAN, 0, 0));
  EXPECT_THROW(certify(problem.graph, problem.start), BadNumber);
}

// ---- real graphs

std::string path_of(const std::string& file) {
  const char* chosen = std::getenv("HOLDFAST_DATA");
  return (chosen != nullptr ? std::string(chosen) : std::string(HOLDFAST_SOURCE_DIR) + "/../shared/data") + "/pose_graph/" + file;
}

class CertificateOfFile : public ::testing::TestWithParam<const char*> {};

TEST_P(CertificateOfFile, IsTightAtTheBestKnownMinimum) {
  if (!std::filesystem::exists(path_of(GetParam()))) GTEST_SKIP() << path_of(GetParam()) << " is not there; set HOLDFAST_DATA";
  const Problem problem = make_problem(read_dataset(path_of(GetParam())), {Loss{}, ProblemOptions::Start::chordal, 0});
  Values values = problem.start;
  Options options;
  options.cost_tolerance = 1e-12;
  const Summary summary = make_backend("irls", options)->solve(problem.graph, values);
  const Certificate certificate = certify(problem.graph, values);
  std::cout << "  " << GetParam() << ": " << certificate.str() << "; solve " << summary.seconds << " s" << std::endl;
  EXPECT_NE(certificate.verdict, Certificate::Verdict::not_certified);
  EXPECT_LE(certificate.bound, certificate.cost);
}

INSTANTIATE_TEST_SUITE_P(Files, CertificateOfFile,
                         ::testing::Values("intel.g2o", "CSAIL.g2o", "M3500.g2o", "MIT.g2o", "sphere2500.g2o", "smallGrid3D.g2o",
                                           "tinyGrid3D.g2o"),
                         [](const auto& file) { return std::filesystem::path(file.param).stem().string(); });

TEST(Certificate, RefusesTheWrongMinimumOfMIT) {
  if (!std::filesystem::exists(path_of("MIT.g2o"))) GTEST_SKIP() << path_of("MIT.g2o") << " is not there; set HOLDFAST_DATA";
  const Problem problem = make_problem(read_dataset(path_of("MIT.g2o")));
  Values values = problem.start;
  IrlsOptions no_restart;
  no_restart.restart = false;
  Irls irls(to_the_bottom(), no_restart);
  const Summary summary = irls.solve(problem.graph, values);
  const Certificate certificate = certify(problem.graph, values);
  std::cout << "  " << certificate.str() << std::endl;
  if (summary.cost < 30) GTEST_SKIP() << "this build does not end in the wrong minimum: cost " << summary.cost;
  EXPECT_EQ(certificate.verdict, Certificate::Verdict::not_certified);
}

}  // namespace
}  // namespace holdfast::testing
