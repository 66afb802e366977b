// Losses that a user writes: a struct with rho(s).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/graph/files/binary.hpp>
#include <holdfast/solvers/convex_start.hpp>
#include <holdfast/testing/loss.hpp>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

using testing::check_loss;
using ::testing::HasSubstr;
using testing::LossCheck;

constexpr Agent A('A');

/// ρ = 2c² (u − ln(1 + u)), u = √s / c (Fair): convex.
struct Fair {
  double c = 1.4;
  static constexpr bool is_convex = true;
  Rho rho(double s) const {
    const double root = std::sqrt(s), u = root / c;
    const double value = u < 1e-4 ? s * (1 - 2 * u / 3) : 2 * c * c * (u - std::log1p(u));
    return {value, 1 / (1 + u), s > 0 ? -0.5 / (c * root * (1 + u) * (1 + u)) : 0};
  }
};
/// Cauchy's, with everything a loss may say of itself.
struct Named {
  double c = 2;
  static const char* name() { return "cauchy_of_mine"; }
  double scale() const { return c; }
  Rho rho(double s) const { return Loss(Cauchy{c}).rho(s); }
  Huber relaxed() const { return {2 * c}; }
  void validate() const {
    if (!(c > 0)) fail<BadNumber>("cauchy_of_mine: c = ", c, " must be > 0 [sigmas]");
  }
};
/// Geman–McClure's: nothing but ρ.
struct Plain {
  double c = 3;
  Rho rho(double s) const { return Loss(GemanMcClure{c}).rho(s); }
};
/// StudentT's: depends on the number of components.
struct OfBlock {
  double nu = 3;
  Rho rho(double s, int d) const { return Loss(StudentT{nu}).rho(s, d); }
};

TEST(OwnLoss, IsCalledByItsRho) {
  const Loss loss = Fair{2};
  EXPECT_EQ(loss.kind, Loss::Kind::Own);
  EXPECT_DOUBLE_EQ(loss.rho(4).value, 8 * (1 - std::log(2.0)));
  EXPECT_DOUBLE_EQ(Loss(OfBlock{4}).rho(2, 3).value, 7 * std::log1p(0.5));
  EXPECT_DOUBLE_EQ(one_sided(Fair{2}).rho_of_component(3).value, 9);
  EXPECT_DOUBLE_EQ(one_sided(Fair{2}).rho_of_component(-2).value, loss.rho(4).value);
}

TEST(OwnLoss, IsTheSameWhereItsNumbersAre) {
  EXPECT_EQ(Loss(Fair{2}), Loss(Fair{2}));
  EXPECT_FALSE(Loss(Fair{2}) == Loss(Fair{3}));
  EXPECT_FALSE(Loss(Fair{2}) == Loss(Plain{2}));
  EXPECT_FALSE(Loss(Fair{2}) == per_component(Fair{2}));
  EXPECT_FALSE(Loss(Fair{2}) == Loss(Huber{2}));
  EXPECT_TRUE(Loss(Fair{2}).is_of_family(Fair{3}));
}

TEST(OwnLoss, PrintsItself) {
  EXPECT_THAT(per_component(Fair{2}).str(), HasSubstr("Fair"));
  EXPECT_EQ(one_sided(Named{1.5}).str(), "cauchy_of_mine:1.5:one_sided");
}

TEST(OwnLoss, IsReadBackWhereItIsRegistered) {
  EXPECT_FALSE(Loss(Fair{}).is_named());
  register_loss<Named>();
  register_loss<Named>();  // again: no matter
  EXPECT_TRUE(Loss(Named{}).is_named());
  EXPECT_EQ(Loss::parse("cauchy_of_mine:0.7:component"), per_component(Named{0.7}));
  EXPECT_EQ(Loss::parse("cauchy_of_mine"), Loss(Named{}));
  EXPECT_THROW(Loss::parse("fair:2"), BadOption);
}

struct Thief : Named {
  static const char* name() { return "huber"; }
};
TEST(OwnLoss, TakesNobodysName) { EXPECT_THROW(register_loss<Thief>(), BadOption); }

TEST(OwnLoss, IsValidatedWhenItIsAdded) {
  Graph graph;
  EXPECT_THROW(graph.add(Range<Point2, Point2>{1, 1}, {A(0), A(1)}, Named{-1}), BadNumber);
  EXPECT_THROW(graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), {1, 1}), {A(0)}, one_sided(Fair{})), BadOption);
}

// ½ρ(r²) of Geman–McClure bends down from s = c²/3 on.
TEST(OwnLoss, RelaxesToWhatItSaysOrToHuberUpToItsBend) {
  EXPECT_EQ(Loss(Fair{2}).relaxed(), Loss(Fair{2}));
  EXPECT_EQ(per_component(Named{1.5}).relaxed(), per_component(Huber{3}));
  const Loss relaxed = Loss(Plain{3}).relaxed();
  EXPECT_EQ(relaxed.kind, Loss::Kind::Huber);
  EXPECT_NEAR(relaxed.scale, std::sqrt(3.0), 0.03);
}

/// The problem under a user's loss is bit by bit the one under the same loss of the library.
TEST(OwnLoss, SolvesAsTheBuiltInOneItIs) {
  const std::pair<Loss, Loss> all[] = {
      {Named{2}, Cauchy{2}}, {per_component(Plain{3}), per_component(GemanMcClure{3})}, {OfBlock{4}, StudentT{4}}};
  for (const char* backend : {"irls", "nesterov"})
    for (const auto& [own, built_in] : all) {
      SCOPED_TRACE(std::string(backend) + " " + built_in.str());
      testing::SmallProblem mine = testing::slam<Pose2>(4, 12, 0.3, own, 0.1), theirs = testing::slam<Pose2>(4, 12, 0.3, built_in, 0.1);
      const Summary a = testing::solve(backend, mine.graph, mine.start, testing::to_the_bottom());
      const Summary b = testing::solve(backend, theirs.graph, theirs.start, testing::to_the_bottom());
      EXPECT_EQ(a.cost, b.cost);
      EXPECT_EQ(a.iterations, b.iterations);
    }
}

TEST(OwnLoss, SharesABatchWithItsOtherThresholds) {
  Graph graph;
  for (int i = 1; i < 50; ++i) graph.add(Range<Point2, Point2>{5, 1}, {A(0), A(1)}, Fair{0.1 * i});
  EXPECT_EQ(graph.batches().size(), 1u);
  EXPECT_EQ(graph.batches()[0]->loss(7), Loss(Fair{0.1 * 8}));
}

std::string saved(const Graph& graph) {
  io::ByteWriter out;
  io::write_binary(out, graph, Values());
  return out.bytes();
}

TEST(OwnLoss, GoesIntoAFileByItsNameAlone) {
  Graph graph;
  graph.add(Range<Point2, Point2>{1, 1}, {A(0), A(1)}, Fair{2});
  try {
    saved(graph);
    FAIL();
  } catch (const BadFile& error) {
    EXPECT_THAT(error.what(), HasSubstr("Fair"));
    EXPECT_THAT(error.what(), HasSubstr("register_loss"));
  }
  register_loss<Named>();
  Graph named;
  named.add(Range<Point2, Point2>{1, 1}, {A(0), A(1)}, Named{2});
  named.add(Range<Point2, Point2>{1, 1}, {A(0), A(1)}, Named{3});
  const std::string bytes = saved(named);
  Graph again;
  Values values;
  io::ByteReader in(bytes);
  io::read_binary(in, again, values);
  for (const int i : {0, 1}) EXPECT_EQ(again.batches()[0]->loss(i), named.batches()[0]->loss(i));
}

// ---- check_loss

TEST(CheckLoss, PassesEveryLossOfOurs) {
  for (int kind = 0; kind < testing::kLossKinds; ++kind) {
    const Loss loss = testing::default_loss(kind);
    LossCheck check;
    check.components = 3;
    if (loss.kind == Loss::Kind::Absolute) check.slope_at_zero = 1 / loss.scale;
    if (loss.kind == Loss::Kind::StudentT) check.slope_at_zero = (loss.scale + 3) / loss.scale;
    EXPECT_EQ(check_loss(loss, check), "") << loss.str();
  }
  EXPECT_EQ(check_loss(Fair{2}), "");
}

/// One mistake at a time in Huber's loss with a = 1.
struct Wrong {
  enum Mistake {
    begins_at_one,
    slope_of_two,
    forgets_constant,
    derivative_of_r,
    second_has_other_sign,
    falls,
    is_convex_in_s,
    no_number
  } mistake;
  Rho rho(double s) const {
    const double root = std::sqrt(s);
    Rho rho = s <= 1 ? Rho{s, 1, 0} : Rho{2 * root - 1, 1 / root, -0.5 / (s * root)};
    if (mistake == begins_at_one) rho.value += 1;
    if (mistake == slope_of_two) rho = {2 * rho.value, 2 * rho.first, 2 * rho.second};
    if (mistake == forgets_constant && s > 1) rho.value += 1;
    if (mistake == derivative_of_r && s > 1) rho.first *= 2;  // dρ/dr = 2a is not dρ/ds
    if (mistake == second_has_other_sign) rho.second = -rho.second;
    if (mistake == falls && s > 1) rho = {2 - s, -1, 0};
    if (mistake == is_convex_in_s) rho = {s * (1 + s), 1 + 2 * s, 2};
    if (mistake == no_number && s > 100) rho.value = NAN;
    return rho;
  }
};

TEST(CheckLoss, NamesEachMistake) {
  const std::pair<Wrong::Mistake, const char*> all[] = {{Wrong::begins_at_one, "rho(0)"},        {Wrong::slope_of_two, "rho'(0)"},
                                                        {Wrong::forgets_constant, "jumps"},      {Wrong::derivative_of_r, "rho'"},
                                                        {Wrong::second_has_other_sign, "rho''"}, {Wrong::falls, "rho'"},
                                                        {Wrong::is_convex_in_s, "not concave"},  {Wrong::no_number, "not finite"}};
  for (const auto& [mistake, words] : all) EXPECT_THAT(check_loss(Wrong{mistake}), HasSubstr(words)) << mistake;
}

struct WrongSecond {
  Rho rho(double s) const {
    Rho rho = Loss(Cauchy{2}).rho(s);
    rho.second *= 1.01;
    return rho;
  }
};
TEST(CheckLoss, SeesASecondDerivativeOffByAPercent) { EXPECT_THAT(check_loss(WrongSecond{}), HasSubstr("rho''")); }

}  // namespace
}  // namespace holdfast
