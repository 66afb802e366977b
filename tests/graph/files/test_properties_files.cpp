// Datasets with any numbers in them: what is written is read back, and noise means the same in every format.
#include <holdfast/testing.hpp>

#include "tests/graph/files/helpers.hpp"
#include "tests/properties.hpp"

namespace holdfast {
namespace {

using properties::any_finite;
using properties::any_rng;
using properties::decades;
using testing_io::parsed;
using testing_io::written;

/// A positive definite matrix of any size, no axis 10⁴ times as sharp as another.
template <int N>
MatrixNoise<N> any_noise(std::mt19937_64& rng, Format format, double size) {
  return {Matrix<N, N>(size * testing::random_covariance<N>(rng, 1e-2)), format};
}

template <class V>
V any_value(std::mt19937_64& rng, double size) {
  Vector<V::dim> delta = testing::random_vector<V::dim>(rng);
  delta.template head<V::space_dim>() *= size;
  return V{}.retract(delta);
}

template <class Pose, class Point>
Dataset any_dataset(std::mt19937_64& rng, Format format, int records) {
  Dataset dataset;
  dataset.format = format;
  const double size = decades(-9, 9), noise = decades(-9, 9);
  const auto time = [&]() -> std::optional<double> {
    if (format == Format::PyFG) return any_finite(rng);
    return std::nullopt;
  };
  const auto key = [&](int i) { return Key(format == Format::PyFG && i % 2 == 1 ? 'B' : 'x', static_cast<std::uint64_t>(i)); };
  for (int i = 0; i < records; ++i) dataset.vertices.push_back({key(i), any_value<Pose>(rng, size), {}, time()});
  const bool has_points = format != Format::Toro;
  if (has_points) dataset.vertices.push_back({key(records), any_value<Point>(rng, size), {}, {}});
  if (format == Format::G2o && Point::dim == 3) dataset.offsets.push_back({0, Pose3(), {}});
  const std::optional<std::uint64_t> offset = dataset.offsets.empty() ? std::nullopt : std::optional<std::uint64_t>(0);
  for (int i = 1; i < records; ++i) {
    dataset.edges.push_back(
        {RelativePoseEdge<Pose>{key(i - 1), key(i), any_value<Pose>(rng, size), {}, any_noise<Pose::dim>(rng, format, noise)}, time()});
    if (!has_points) continue;
    dataset.edges.push_back(
        {RelativePointEdge<Point>{key(i), key(records), any_value<Point>(rng, size), {}, any_noise<Point::dim>(rng, format, noise), offset},
         time()});
    dataset.edges.push_back(
        {PriorEdge<Pose>{key(i), any_value<Pose>(rng, size), {}, any_noise<Pose::dim>(rng, format, noise), {}}, time()});
    if (format == Format::PyFG) dataset.edges.push_back({RangeEdge{key(i), key(records), std::abs(any_finite(rng)), noise}, time()});
  }
  return dataset;
}

template <class Pose, class Point>
void expect_back(Format format) {
  std::mt19937_64 rng = any_rng();
  const Dataset dataset = any_dataset<Pose, Point>(rng, format, *rc::gen::inRange(1, 12).as("records"));
  const std::string text = written(dataset);
  const Dataset again = parsed(text, format);
  RC_ASSERT(written(again) == text);
  RC_ASSERT(again.vertices.size() == dataset.vertices.size());
  for (std::size_t i = 0; i < again.vertices.size(); ++i) {
    RC_ASSERT(again.vertices[i].key == dataset.vertices[i].key);
    RC_ASSERT(again.vertices[i].time == dataset.vertices[i].time);
    RC_ASSERT(again.vertices[i].value.index() == dataset.vertices[i].value.index());
    std::visit(
        [&](const auto& value) {
          const auto& read = std::get<std::decay_t<decltype(value)>>(again.vertices[i].value);
          RC_ASSERT(value.position() == read.position());
          RC_ASSERT(value.local(read).norm() < 1e-14);
        },
        dataset.vertices[i].value);
  }
  RC_ASSERT(again.edges.size() == dataset.edges.size());
  for (std::size_t i = 0; i < again.edges.size(); ++i) {
    RC_ASSERT(again.edges[i].time == dataset.edges[i].time);
    RC_ASSERT(keys_of(again.edges[i].measurement) == keys_of(dataset.edges[i].measurement));
    RC_ASSERT(again.edges[i].measurement.index() == dataset.edges[i].measurement.index());
  }
}

RC_GTEST_PROP(FileProperties, WhatIsWrittenIsReadBack, ()) {
  const Format format = *rc::gen::element(Format::PyFG, Format::G2o, Format::Toro);
  if (*rc::gen::arbitrary<bool>().as("plane"))
    expect_back<Pose2, Point2>(format);
  else
    expect_back<Pose3, Point3>(format);
}

template <class Pose>
void expect_same_noise() {
  std::mt19937_64 rng = any_rng();
  const Format from = *rc::gen::element(Format::PyFG, Format::G2o, Format::Toro),
               to = *rc::gen::element(Format::PyFG, Format::G2o, Format::Toro);
  const Pose measured = any_value<Pose>(rng, 10);
  const MatrixNoise<Pose::dim> noise = any_noise<Pose::dim>(rng, from, decades(-9, 9));
  const auto expected = noise.information(measured), there = noise.converted(to, measured).information(measured);
  RC_ASSERT((there - expected).cwiseAbs().maxCoeff() <= 1e-10 * expected.cwiseAbs().maxCoeff());
}

RC_GTEST_PROP(FileProperties, NoiseMeansTheSameInEveryFormat, ()) {
  expect_same_noise<Pose2>();
  expect_same_noise<Pose3>();
}

// Whatever the bytes are: BadFile, or a dataset that can be written and read.
RC_GTEST_PROP(FileProperties, DamagedFilesAreRefusedOrRead, ()) {
  std::mt19937_64 rng = any_rng();
  std::string text = written(any_dataset<Pose2, Point2>(rng, Format::PyFG, 4));
  const int damages = *rc::gen::inRange(1, 4).as("damages");
  for (int i = 0; i < damages; ++i) {
    const std::size_t at = rng() % text.size();
    switch (rng() % 4) {
      case 0:
        text[at] = static_cast<char>(rng());
        break;
      case 1:
        text.erase(at, rng() % 20);
        break;
      case 2:
        text.insert(at, text.substr(rng() % text.size(), rng() % 40));
        break;
      case 3:
        text.resize(at + 1);
        break;
    }
  }
  try {
    const Dataset dataset = parsed(text, Format::PyFG);
    RC_ASSERT(written(parsed(written(dataset), Format::PyFG)) == written(dataset));
  } catch (const BadFile&) {
  }
}

}  // namespace
}  // namespace holdfast
