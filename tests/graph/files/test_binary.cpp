// A graph's bytes: back with the same numbers, and refused by name where they say what no graph is.
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/graph/linear_prior.hpp>

#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using testing_io::expect_message;

constexpr Agent A('A');

/// A graph of one linear prior, as its bytes; on no variables where there are no `keys`.
std::string one_prior(std::size_t keys, std::int32_t rows) {
  io::ByteWriter out;
  out.put<std::uint64_t>(1).put(std::string_view("Point2")).put<std::int32_t>(2).put<std::uint64_t>(1);  // one pool of one variable
  out.put(A(0)).put(1.0).put(2.0);
  out.put<std::uint64_t>(0);                                                                   // nothing is fixed
  out.put<std::uint64_t>(1).put<std::uint32_t>(0).put<std::uint64_t>(0).put<std::int32_t>(0);  // factor 0 has a name
  out.put<std::uint64_t>(1).put(std::string_view("LinearPrior"));                              // one batch
  out.put(std::string_view("squared")).put(true).put<std::uint64_t>(1).put(1.0);               // one loss for all, one factor, weight 1
  out.put<std::uint64_t>(keys);
  for (std::size_t k = 0; k < keys; ++k) out.put(A(0)).put(std::string_view("Point2")).put<std::int32_t>(2).put(0.0).put(0.0);
  out.put<std::int32_t>(rows).put(0.0);
  for (std::int64_t i = 0; i < std::int64_t{rows} * (2 * static_cast<std::int64_t>(keys) + 1); ++i) out.put(i == 0 ? 1.0 : 0.0);
  return out.bytes();
}

/// What the bytes hold, and its cost.
double cost_of(const std::string& bytes) {
  Values().insert(A(0), Point2(0, 0));  // a program knows the types that it inserts
  io::ByteReader in(bytes);
  Graph graph;
  Values values;
  io::read_binary(in, graph, values);
  EXPECT_TRUE(in.at_end());
  EXPECT_EQ(graph.size(), 1u);
  return graph.cost(values);
}

TEST(Binary, HoldsALinearPrior) {
  EXPECT_DOUBLE_EQ(cost_of(one_prior(1, 1)), 0.5);
}  // A = (1 0), b = 0 about x₀ = 0: the point is at (1, 2)

TEST(Binary, RefusesAPriorOfNothing) {
  expect_message<BadFile>([] { cost_of(one_prior(0, 1)); }, {"LinearPrior without variables"});
  expect_message<BadFile>([] { cost_of(one_prior(1, 0)); }, {"LinearPrior without rows"});
}

// ---- factors by their fields

/// A factor of one's own with every kind of field.
struct Everything {
  enum class Kind : std::int32_t { first, second };
  struct Bias {
    double offset, rate;
    static constexpr auto fields() { return std::tuple(field("offset", &Bias::offset), field("rate", &Bias::rate)); }
  };
  Kind kind;
  bool flag;
  int count;
  float small;
  Pose2 pose;
  Matrix<2, 3> matrix;
  std::array<double, 2> pair;
  Bias bias;
  using Variables = variables<Point2>;
  static constexpr int residual_dim = 1;
  static constexpr auto fields() {
    return std::tuple(field("kind", &Everything::kind), field("flag", &Everything::flag), field("count", &Everything::count),
                      field("small", &Everything::small), field("pose", &Everything::pose), field("matrix", &Everything::matrix),
                      field("pair", &Everything::pair), field("bias", &Everything::bias));
  }
  Vector<1> operator()(const Point2& x, Jacobians<Everything>* J = nullptr) const {
    if (J != nullptr) J->all << 1, 0;
    return Vector<1>(x.x());
  }
};

TEST(BinaryFields, OfEveryKindComeBack) {
  Everything factor{Everything::Kind::second, true, -7, 0.25f, Pose2(1, 2, 3), {}, {4, -0.0}, {5, 6}};
  factor.matrix << 1, 2, 3, 4, 5, std::nan("7");
  Graph graph, again;
  Values values, same;
  const FactorId id = graph.add(factor, {A(0)});
  io::ByteWriter out;
  io::write_binary(out, graph, values);
  io::ByteReader in(out.bytes());
  io::read_binary(in, again, same);
  const Everything& read = again.at<Everything>(id);
  EXPECT_EQ(read.kind, factor.kind);
  EXPECT_EQ(read.flag, factor.flag);
  EXPECT_EQ(read.count, factor.count);
  EXPECT_EQ(read.small, factor.small);
  EXPECT_TRUE(testing_io::same_bits(read.pose, factor.pose));
  EXPECT_TRUE(testing_io::same_bits(read.matrix, factor.matrix));  // the NaN, too
  EXPECT_TRUE(testing_io::same_bits(read.pair, factor.pair));      // and the sign of −0
  EXPECT_EQ(read.bias.offset, factor.bias.offset);
  EXPECT_EQ(read.bias.rate, factor.bias.rate);
}

TEST(BinaryFields, AreNamedWithTheirTypes) {
  std::string text;
  for (const FieldType& f : detail::fields_of<Everything>()) text += f.name + " " + f.type + " " + std::to_string(f.bytes) + "\n";
  EXPECT_EQ(text,
            "kind enum int32 4\nflag bool 1\ncount int32 4\nsmall float32 4\npose Pose2[4] 32\nmatrix double[2x3] 48\n"
            "pair double[2] 16\nbias {offset double, rate double} 16\n");
}

/// A factor that looks at somebody's memory: it cannot come back.
struct Watching {
  const double* watched;
  using Variables = variables<Point2>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "Watching"; }
  Vector<1> operator()(const Point2& x, Jacobians<Watching>* J = nullptr) const {
    if (J != nullptr) J->all << 1, 0;
    return Vector<1>(x.x() - *watched);
  }
};

TEST(BinaryFields, AFactorThatHoldsAPointerIsRefusedByName) {
  const double number = 1;
  Graph graph;
  graph.add(Watching{&number}, {A(0)});
  expect_message<BadFile>(
      [&] {
        io::ByteWriter out;
        io::write_binary(out, graph, Values());
      },
      {"a factor Watching cannot be saved", "fields()"});
}

using Fields = std::vector<std::pair<std::string, std::string>>;

/// A graph of one Range, as a program with these fields writes it; every number is a 2.
std::string one_range(const Fields& fields) {
  Graph graph;
  graph.add(Range<Point2, Point2>{1, 1}, {A(0), A(1)});  // this program knows the type
  io::ByteWriter out;
  out.put<std::uint64_t>(0).put<std::uint64_t>(0);                                             // no values, nothing is fixed
  out.put<std::uint64_t>(1).put<std::uint32_t>(0).put<std::uint64_t>(0).put<std::int32_t>(0);  // factor 0
  out.put<std::uint64_t>(1).put(std::string_view(find_factor_type(typeid(Range<Point2, Point2>))->name));
  out.put<std::uint64_t>(fields.size());
  for (const auto& [name, type] : fields) out.put(std::string_view(name)).put(std::string_view(type));
  out.put(std::string_view("squared")).put(true).put<std::uint64_t>(1).put(1.0).put(A(0)).put(A(1));
  for (std::size_t i = 0; i < fields.size(); ++i) out.put(2.0 + static_cast<double>(i));
  return out.bytes();
}

Range<Point2, Point2> read_range(const std::string& bytes) {
  io::ByteReader in(bytes);
  Graph graph;
  Values values;
  io::read_binary(in, graph, values);
  return graph.at<Range<Point2, Point2>>(graph.id_of(0, 0));
}

TEST(BinaryFields, AreFoundByNameAndNotByPlace) {
  EXPECT_EQ(read_range(one_range({{"distance", "double"}, {"sigma", "double"}})).sigma, 3);
  EXPECT_EQ(read_range(one_range({{"sigma", "double"}, {"distance", "double"}})).sigma, 2);
}

TEST(BinaryFields, ThatDoNotFitAreRefusedByName) {
  expect_message<BadFile>([] { read_range(one_range({{"distance", "double"}})); }, {"Range", "no field sigma (double)"});
  expect_message<BadFile>(
      [] {
        read_range(one_range({{"distance", "double"}, {"sigma", "double"}, {"bias", "double"}}));
      },
      {"Range", "field bias (double)", "have not here"});
  expect_message<BadFile>(
      [] {
        read_range(one_range({{"distance", "double"}, {"sigma", "int64"}}));
      },
      {"field sigma", "int64, here double"});
  expect_message<BadFile>([] { read_range(one_range({{"sigma", "double"}, {"sigma", "double"}})); }, {"sigma twice"});
}

// ---- whatever happens to the bytes: an error that says so, or a graph; never a crash

TEST(Binary, SurvivesEveryChangedAndMissingByte) {
  Graph graph;
  graph.add(Everything{Everything::Kind::first, false, 1, 1, Pose2(), Matrix<2, 3>::Zero(), {1, 2}, {3, 4}}, {A(0)}, Huber{2}, 0.5);
  graph.remove(graph.add(Range<Point2, Point2>{1, 1}, {A(0), A(1)}));
  graph.add(Range<Point2, Point2>{2, 1}, {A(0), A(1)});
  graph.fix(A(1));
  Values values;
  values.insert(A(0), Point2(1, 2));
  values.insert(A(1), Point2(3, 4));
  io::ByteWriter out;
  io::write_binary(out, graph, values);
  int refused = 0, tried = 0;
  const auto attempt = [&](const std::string& bytes) {
    ++tried;
    Graph into;
    Values read;
    try {
      io::ByteReader in(bytes);
      io::read_binary(in, into, read);
      into.cost(read);
    } catch (const Error&) {
      ++refused;
    }
  };
  const std::string& good = out.bytes();
  for (std::size_t i = 0; i < good.size(); ++i) {
    attempt(good.substr(0, i));
    for (int flip : {0x01, 0x80, 0xff}) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ flip);
      attempt(bad);
    }
  }
  EXPECT_GT(refused, tried / 2);
  EXPECT_LT(refused, tried);  // a changed number is a number
}

}  // namespace
}  // namespace holdfast
