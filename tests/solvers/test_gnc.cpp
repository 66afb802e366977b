#include <gtest/gtest.h>

#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/irls/irls.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), L('L');

Options tight() {
  Options options;
  options.cost_tolerance = 1e-12;
  return options;
}

/// Poses round a ring, odometry and loop closures between poses far apart in time, some of them false; starts from the odometry.
struct Ring {
  Graph graph;
  Values truth, start;
  std::vector<FactorId> good, bad;

  Ring(std::uint64_t seed, const Loss& loss, double sigma = 0.02) {
    constexpr int poses = 60, laps = 3;
    std::mt19937_64 rng(seed);
    const Vector<3> sigmas(sigma, sigma, 0.2 * sigma);
    const auto noisy = [&](const Pose2& z) { return z.retract(random_vector<3>(rng).cwiseProduct(sigmas)); };
    const auto pose = [&](int i) {
      const double angle = 2 * kPi * laps * i / poses, radius = 5 + 0.1 * i;
      return Pose2(radius * std::cos(angle), radius * std::sin(angle), angle + kPi / 2);
    };
    Pose2 odometry = pose(0);
    graph.add(Prior<Pose2>::from_sigmas(pose(0), sigmas), {A(0)});
    for (int i = 0; i < poses; ++i) {
      truth.insert(A(i), pose(i));
      if (i > 0) {
        const Pose2 z = noisy(pose(i - 1).inverse() * pose(i));
        odometry = odometry * z;
        graph.add(Between<Pose2>::from_sigmas(z, sigmas), {A(i - 1), A(i)});
      }
      start.insert(A(i), odometry);
    }
    for (int i = 0; i + poses / laps < poses; ++i) {
      const int j = i + poses / laps;
      const bool is_false = i % 10 < 3;
      Pose2 z = noisy(pose(i).inverse() * pose(j));
      if (is_false) z = Pose2(uniform(rng, -8, 8), uniform(rng, -8, 8), uniform(rng, -3, 3));
      (is_false ? bad : good).push_back(graph.add(Between<Pose2>::from_sigmas(z, sigmas), {A(i), A(j)}, loss));
    }
  }
  /// Least squares by one who knows which closures are false.
  Values oracle() const {
    Graph known = graph;
    for (FactorId id : bad) known.remove(id);
    for (std::size_t b = 0; b < known.batches().size(); ++b) known.set_loss(static_cast<int>(b), Squared{});
    Values x = truth;
    solve("irls", known, x, tight());
    return x;
  }
};

TEST(Gnc, RecoversARingWithFalseClosures) {
  for (const Loss& loss : {Loss(TruncatedSquares{4}), Loss(GemanMcClure{4})})
    for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
      const Ring ring(seed, loss);
      Values x = ring.start;
      const auto backend = gnc(make_backend("irls", tight()));
      const Summary summary = backend->solve(ring.graph, x);
      SCOPED_TRACE(loss.str() + " seed " + std::to_string(seed) + ": " + summary.str());
      EXPECT_EQ(summary.termination, Termination::converged);
      const bool truncated = loss.kind == Loss::Kind::TruncatedSquares;
      EXPECT_LT(largest_difference(ring.oracle(), x), truncated ? 1e-6 : 0.02);  // with these weights it is the same problem
      EXPECT_LT(largest_difference(ring.truth, x), 0.4);  // what odometry of 2 cm and 0.23° leaves open after three laps
      EXPECT_NEAR(summary.cost, ring.graph.cost(x), 1e-12 * summary.cost);
      EXPECT_LE(summary.cost, summary.cost_first);
      EXPECT_EQ(backend->weights().size(), ring.good.size() + ring.bad.size());
      for (FactorId id : ring.bad) EXPECT_LT(backend->weight(id), 0.01);
      for (FactorId id : ring.good) EXPECT_GT(backend->weight(id), truncated ? 0.9 : 0.1);
    }
}

TEST(Gnc, IsNeededThere) {
  int lost = 0;
  const IrlsOptions local{Reweighting::automatic, false};  // a second start finds the way out of some of them
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const Ring ring(seed, TruncatedSquares{4}, 0.1);  // the odometry drifts beyond the truncation
    Values plain = ring.start, graduated = ring.start;
    Irls(tight(), local).solve(ring.graph, plain);
    gnc(make_backend("irls", tight()))->solve(ring.graph, graduated);
    const Values oracle = ring.oracle();
    EXPECT_LT(largest_difference(oracle, graduated), 1e-6) << seed;
    lost += largest_difference(oracle, plain) > 0.5 && ring.graph.cost(plain) > 1.1 * ring.graph.cost(graduated);
  }
  EXPECT_GE(lost, 3);
}

TEST(Gnc, GivesTheSameAnswerWithAnyInnerBackEnd) {
  for (const Loss& loss : {Loss(TruncatedSquares{4}), Loss(GemanMcClure{4})}) {
    const Ring ring(6, loss);
    Values irls = ring.start, nesterov = ring.start;
    const auto first = gnc(make_backend("irls", tight())), second = gnc(make_backend("nesterov", tight()));
    EXPECT_EQ(first->name(), "gnc-irls");
    EXPECT_EQ(second->name(), "gnc-nesterov");
    const double cost = first->solve(ring.graph, irls).cost;
    EXPECT_NEAR(second->solve(ring.graph, nesterov).cost, cost, 1e-6 * cost);
    EXPECT_LT(largest_difference(irls, nesterov), 1e-3);
    for (const Gnc::TermWeight& term : first->weights()) EXPECT_NEAR(second->weight(term.id), term.weight, 1e-3);
  }
}

/// Notes the size of every problem it is asked to solve.
class Recorder final : public Backend {
 public:
  std::string name() const override { return "recorder"; }
  std::vector<std::size_t> sizes;

 protected:
  Summary minimize(const Graph& graph, Values& values) override {
    sizes.push_back(graph.size());
    for (const auto& batch : graph.batches()) EXPECT_EQ(batch->family().kind, Loss::Kind::Squared);
    return make_backend("irls", options)->solve(graph, values);
  }
};

TEST(Gnc, LeavesRejectedTermsOutOfTheProblem) {
  const Ring ring(3, TruncatedSquares{4});
  auto recorder = std::make_unique<Recorder>();
  const Recorder& inner = *recorder;
  GncOptions once;
  once.second_chances = false;  // whose trials come last, and may be in vain
  const auto backend = gnc(std::move(recorder), once);
  for (int solves = 0; solves < 2; ++solves) {
    Values x = ring.start;
    EXPECT_EQ(backend->solve(ring.graph, x).termination, Termination::converged);
    const auto few = static_cast<std::size_t>(0.05 * static_cast<double>(ring.good.size() + ring.bad.size()));
    EXPECT_LE(inner.sizes.back(), ring.graph.size() - ring.bad.size() + few);
    EXPECT_GE(inner.sizes.back(), ring.graph.size() - ring.bad.size());
  }
}

// To let in a false closure of metres against odometry of centimetres costs more than all that is rejected: no trial is made.
TEST(Gnc, TriesNoLoopThatCostsMoreThanThereIsToGain) {
  const Ring ring(3, TruncatedSquares{4});
  std::size_t without = 0, with_chances = 0;
  for (const bool chances : {false, true}) {
    auto recorder = std::make_unique<Recorder>();
    const Recorder& inner = *recorder;
    GncOptions options;
    options.second_chances = chances;
    Values x = ring.start;
    gnc(std::move(recorder), options)->solve(ring.graph, x);
    (chances ? with_chances : without) = inner.sizes.size();
  }
  EXPECT_GT(with_chances, without);                            // from the chordal start
  EXPECT_LT(with_chances, 2 * without + ring.bad.size() / 2);  // and not one for each false closure
}

// False loops at full weight fold the map, and it stays folded: the first problem must not have them so.
TEST(Gnc, TrustsAStartThatDeadReckoningGives) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Ring ring(seed, TruncatedSquares{4});
    std::mt19937_64 rng(seed);
    for (int more = 0; more < 200; ++more) {  // five false loops for a true one
      const int i = static_cast<int>(rng() % 60), j = static_cast<int>(rng() % 60);
      if (std::abs(i - j) < 2) continue;
      const Pose2 z(uniform(rng, -8, 8), uniform(rng, -8, 8), uniform(rng, -3, 3));
      ring.bad.push_back(ring.graph.add(Between<Pose2>::from_sigmas(z, {0.02, 0.02, 0.004}), {A(i), A(j)}, TruncatedSquares{4}));
    }
    Values x = ring.start;
    const auto backend = gnc(make_backend("irls", tight()));
    EXPECT_EQ(backend->solve(ring.graph, x).termination, Termination::converged);
    EXPECT_LT(largest_difference(ring.oracle(), x), 1e-6) << seed;
    for (FactorId id : ring.bad) EXPECT_EQ(backend->weight(id), 0);
  }
}

TEST(Gnc, KeepsKnownInliers) {
  const Ring ring(1, TruncatedSquares{4});
  GncOptions options;
  options.known_inliers = {ring.good[0], ring.bad[0]};  // even where it should not
  const auto backend = gnc(make_backend("irls"), options);
  Values x = ring.start;
  EXPECT_TRUE(backend->solve(ring.graph, x).usable());
  EXPECT_EQ(backend->weight(ring.good[0]), 1);
  EXPECT_EQ(backend->weight(ring.bad[0]), 1);
}

TEST(Gnc, SolvesAgainOnOtherMeasurements) {
  Ring ring(2, TruncatedSquares{4});
  const auto backend = gnc(make_backend("irls", tight()));
  Values x = ring.start, fresh = ring.start;
  backend->solve(ring.graph, x);
  ring.graph.at<Between<Pose2>>(ring.good[0]).measured.p[0] += 5;  // now it is false, too
  x = ring.start;
  backend->solve(ring.graph, x);
  EXPECT_EQ(backend->weight(ring.good[0]), 0);
  gnc(make_backend("irls", tight()))->solve(ring.graph, fresh);
  EXPECT_LT(largest_difference(x, fresh), 1e-12);
}

/// The mean of measurements 0, 0.2, 0.4 (σ = 1) and the outlier 100.
struct Mean {
  Graph graph;
  Values start;
  std::vector<FactorId> ids;

  explicit Mean(const Loss& loss) {
    start.insert(L(0), Point2(50, 0));
    for (const double z : {0.0, 0.2, 0.4, 100.0}) ids.push_back(graph.add(Prior<Point2>::from_sigmas(Point2(z, 0), {1, 1}), {L(0)}, loss));
  }
};

TEST(Gnc, OfAMeanByHand) {
  Mean truncated(TruncatedSquares{3});
  const auto tls = gnc(make_backend("irls"));
  const Summary summary = tls->solve(truncated.graph, truncated.start);
  EXPECT_NEAR(truncated.start.at<Point2>(L(0)).value[0], 0.2, 1e-9);
  EXPECT_NEAR(summary.cost, 0.5 * (0.04 + 0 + 0.04 + 9), 1e-9);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(tls->weight(truncated.ids[i]), i < 3 ? 1 : 0);

  Mean smooth(GemanMcClure{3});
  const auto gm = gnc(make_backend("irls", tight()));
  gm->solve(smooth.graph, smooth.start);
  const double x = smooth.start.at<Point2>(L(0)).value[0];
  double slope = 0;
  for (int i = 0; i < 4; ++i) {
    const double r = x - (i < 3 ? 0.2 * i : 100), w = 81 / ((9 + r * r) * (9 + r * r));
    EXPECT_NEAR(gm->weight(smooth.ids[i]), w, 1e-6);
    slope += w * r;
  }
  EXPECT_NEAR(slope, 0, 1e-6);
  EXPECT_NEAR(x, 0.2, 1e-2);
}

/// ρ of Cauchy, as a user writes it.
struct OwnCauchy {
  double c = 1;
  Rho rho(double s) const {
    const double u = 1 / (1 + s / (c * c));
    return {c * c * std::log1p(s / (c * c)), u, -u * u / (c * c)};
  }
};

// From a start in the middle a redescending loss alone is pulled to the outlier's side or stays; widened first, it finds the three.
TEST(Gnc, WidensEveryLossThatIsNotConvex) {
  for (const Loss& loss : {Loss(Cauchy{1}), Loss(Welsch{3}), Loss(Tukey{4}), Loss(StudentT{2}), Loss(OwnCauchy{1})}) {
    SCOPED_TRACE(loss.str());
    Mean mean(loss);
    const auto backend = gnc(make_backend("irls", tight()));
    EXPECT_EQ(backend->solve(mean.graph, mean.start).termination, Termination::converged);
    const double x = mean.start.at<Point2>(L(0)).value[0];
    EXPECT_NEAR(x, 0.2, 0.05);
    double slope = 0;
    for (int i = 0; i < 4; ++i) {
      const double r = x - (i < 3 ? 0.2 * i : 100), w = loss.rho(r * r, 2).first;
      EXPECT_NEAR(backend->weight(mean.ids[i]), w / loss.rho(0, 2).first, 1e-6);
      slope += w * r;
    }
    EXPECT_NEAR(slope, 0, 1e-5);  // a stationary point of the cost itself
  }
}

TEST(Gnc, TakesAUsersLossAsTheOneItIs) {
  Mean own(OwnCauchy{1.5}), built_in(Cauchy{1.5});
  gnc(make_backend("irls", tight()))->solve(own.graph, own.start);
  gnc(make_backend("irls", tight()))->solve(built_in.graph, built_in.start);
  EXPECT_EQ(own.start.at<Point2>(L(0)).value[0], built_in.start.at<Point2>(L(0)).value[0]);
}

// Three measurements that agree, and one far out that is known to be an inlier: μ is where it ends at once, and each ω is ρ'.
TEST(Gnc, FirstMuIsThatOfTheTermsThatAreNotKnown) {
  for (const Loss& loss : {Loss(TruncatedSquares{3}), Loss(GemanMcClure{3}), Loss(Cauchy{3})}) {
    Mean mean(loss);
    mean.graph.remove(mean.ids[3]);
    GncOptions options;
    options.known_inliers = {mean.graph.add(Prior<Point2>::from_sigmas(Point2(0.2, 1000), {1, 1}), {L(0)}, loss, 1e-12)};
    options.max_outer_iterations = 1;
    const auto backend = gnc(make_backend("irls", tight()), options);
    backend->solve(mean.graph, mean.start);
    for (int i = 0; i < 3; ++i) {
      const double r = 0.2 - 0.2 * i;
      EXPECT_NEAR(backend->weight(mean.ids[i]), loss.rho(r * r).first, 1e-6) << loss.str();
    }
  }
}

TEST(Gnc, LeavesConvexLossesAlone) {
  for (const Loss& loss : {Loss(Huber{2}), Loss(PseudoHuber{2})}) {
    const SmallProblem problem = slam<Pose2>(3, 15, 0.1, loss, 0.01);
    Values plain = problem.start, wrapped = problem.start;
    solve("irls", problem.graph, plain, tight());
    const auto backend = gnc(make_backend("irls", tight()));
    EXPECT_EQ(backend->solve(problem.graph, wrapped).termination, Termination::converged);
    EXPECT_LT(largest_difference(plain, wrapped), 1e-6) << loss.str();
    EXPECT_TRUE(backend->weights().empty());
  }
}

TEST(Gnc, KeepsAOneSidedTermOnItsSquaredSide) {
  Graph graph;
  Values x;
  x.insert(L(0), Point2(0, 0));
  x.insert(L(1), Point2(5, 0));
  graph.fix(L(0));
  graph.add(Prior<Point2>::from_sigmas(Point2(5, 0), {1, 1}), {L(1)});
  const FactorId too_long = graph.add(Range<Point2, Point2>{90, 0.5}, {L(0), L(1)}, one_sided(TruncatedSquares{3}));
  const FactorId too_short = graph.add(Range<Point2, Point2>{1, 0.5}, {L(0), L(1)}, one_sided(TruncatedSquares{3}));
  const auto backend = gnc(make_backend("irls", tight()));
  backend->solve(graph, x);
  EXPECT_EQ(backend->weight(too_long), 0);
  EXPECT_EQ(backend->weight(too_short), 1);
  EXPECT_NEAR(x.at<Point2>(L(1)).value[0], (5 + 4 * 1) / 5.0, 1e-6);
}

TEST(Gnc, KeepsTheStartWhereItEndsHigher) {
  Mean mean(TruncatedSquares{3});
  mean.start.at<Point2>(L(0)) = Point2(0.2, 0);
  GncOptions options;
  options.max_outer_iterations = 1;  // plain least squares
  const Summary summary = gnc(make_backend("irls"), options)->solve(mean.graph, mean.start);
  EXPECT_EQ(mean.start.at<Point2>(L(0)).value[0], 0.2);
  EXPECT_EQ(summary.cost, summary.cost_first);
  EXPECT_TRUE(summary.usable());
  EXPECT_NE(summary.why().find("start"), std::string::npos);
}

// Odometry that has drifted far: which loops are believed first decides, and a second chance mends it.
TEST(Gnc, SecondChancesEndLowerNeverHigher) {
  int lower = 0;
  for (std::uint64_t seed = 26; seed <= 37; ++seed) {
    const Ring ring(seed, TruncatedSquares{3}, 0.5);
    GncOptions once;
    once.second_chances = false;
    Values first = ring.start, both = ring.start;
    const double cost = gnc(make_backend("irls"), once)->solve(ring.graph, first).cost;
    const Summary summary = gnc(make_backend("irls"))->solve(ring.graph, both);
    EXPECT_TRUE(summary.usable()) << summary.str();
    EXPECT_LE(summary.cost, cost * (1 + 1e-9)) << seed;
    EXPECT_NEAR(summary.cost, ring.graph.cost(both), 1e-9 * summary.cost);
    const double oracle = ring.graph.cost(ring.oracle());
    lower += summary.cost < 0.995 * cost && summary.cost < oracle * (1 + 1e-3);  // one who knows which are false ends no lower
  }
  EXPECT_GE(lower, 1);
}

TEST(Gnc, StopsInASecondChanceWhenAsked) {
  const Ring ring(31, TruncatedSquares{3}, 0.5);  // where one helps
  int calls_once = 0, calls = 0;
  GncOptions once;
  once.second_chances = false;
  const auto plain = gnc(make_backend("irls"), once), chances = gnc(make_backend("irls"));
  plain->options.progress = [&](const Iteration&) { return ++calls_once > 0; };
  Values first = ring.start, stopped = ring.start;
  const double cost = plain->solve(ring.graph, first).cost;
  chances->options.progress = [&](const Iteration&) { return ++calls <= calls_once; };
  const Summary summary = chances->solve(ring.graph, stopped);
  EXPECT_EQ(calls, calls_once + 1);
  EXPECT_EQ(summary.termination, Termination::stopped);
  EXPECT_DOUBLE_EQ(summary.cost, cost);  // the best so far
  EXPECT_DOUBLE_EQ(ring.graph.cost(stopped), cost);
}

TEST(Gnc, StopsWhenAsked) {
  Ring ring(1, GemanMcClure{4});
  const auto backend = gnc(make_backend("irls"));
  int calls = 0;
  backend->options.progress = [&](const Iteration&) { return ++calls < 3; };
  backend->options.trace = true;
  const Summary summary = backend->solve(ring.graph, ring.start);
  EXPECT_EQ(summary.termination, Termination::stopped);
  EXPECT_EQ(summary.trace.size(), 3u);
}

TEST(Gnc, RefusesBadOptions) {
  EXPECT_THROW(gnc(nullptr), BadOption);
  for (const double mu_factor : {1.0, 0.5, -1.0, double(NAN), double(INFINITY)}) {
    GncOptions options;
    options.mu_factor = mu_factor;
    EXPECT_THROW(gnc(make_backend("irls"), options), BadOption) << mu_factor;
  }
  GncOptions options;
  options.max_outer_iterations = 0;
  EXPECT_THROW(gnc(make_backend("irls"), options), BadOption);
  options = {};
  options.known_inliers = {FactorId{1000, 0}};
  Ring ring(1, TruncatedSquares{4});
  EXPECT_THROW(gnc(make_backend("irls"), options)->solve(ring.graph, ring.start), BadKey);
  EXPECT_THROW(gnc(make_backend("irls"))->weight(ring.good[0]), BadKey);
}

TEST(Gnc, NamesAFactorWhoseResidualIsNotFinite) {
  Ring ring(1, TruncatedSquares{4});
  ring.start.at<Pose2>(A(7)).p[0] = NAN;
  const Summary summary = gnc(make_backend("irls"))->solve(ring.graph, ring.start);
  EXPECT_EQ(summary.termination, Termination::failed);
  EXPECT_NE(summary.culprit.find("A7"), std::string::npos);
}

TEST(Graph, ChangesAWeightWithoutChangingTheStructure) {
  Mean mean(Squared{});
  const std::uint64_t structure = mean.graph.structure();
  mean.graph.set_weight(mean.ids[3], 0);
  EXPECT_EQ(mean.graph.structure(), structure);
  EXPECT_DOUBLE_EQ(mean.graph.cost(mean.start), 0.5 * (50 * 50 + 49.8 * 49.8 + 49.6 * 49.6));
  EXPECT_THROW(mean.graph.set_weight(mean.ids[3], -1), BadNumber);
  EXPECT_THROW(mean.graph.set_weight(mean.ids[3], NAN), BadNumber);
  EXPECT_THROW(mean.graph.set_weight(FactorId{7, 0}, 1), BadKey);
}

}  // namespace
}  // namespace holdfast::testing
