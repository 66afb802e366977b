// How agents move, and paper A's measurements of it.
#include <holdfast/factors/constant_turn.hpp>
#include <holdfast/factors/coordinated_turn.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/factors/white_jerk.hpp>

#include "bind_window.hpp"

namespace holdfast::python {

namespace {

template <class V>
void bind_white_acceleration(nb::module_& m) {
  using F = WhiteAcceleration<V>;
  using Square = typename F::Square;
  auto c = bind_factor<F>(m);
  bind_stepped_motion(c);
  bind_odometry(c);
  c.def_static(
       "exact", [](double dt, int steps, nb::handle R) { return F::exact(dt, steps, numbers<Square>("R", R)); }, "dt"_a, "steps"_a, "R"_a,
       "R: covariance of the noise of each step")
      .def_static("continuous", &F::continuous, "duration"_a, "q"_a, "q: density of the acceleration [m²/s³]")
      .def_static(
          "paper", [](double dt, int steps, nb::handle R) { return F::paper(dt, steps, numbers<Square>("R", R)); }, "dt"_a, "steps"_a,
          "R"_a)
      .def_static(
          "recursive",
          [](double dt, int steps, nb::handle R, nb::handle P_start) {
            return F::recursive(dt, steps, numbers<Square>("R", R), numbers<Square>("P_start", P_start));
          },
          "dt"_a, "steps"_a, "R"_a, "P_start"_a)
      .def_static(
          "steered",
          [](double duration, nb::handle direction, double along, double across) {
            return F::steered(duration, numbers<Vector<V::axes>>("direction", direction), along, across);
          },
          "duration"_a, "direction"_a, "along"_a, "across"_a)
      .def("merged", &F::merged, "m"_a, "one factor for m times as many steps");
}

template <class V>
void bind_white_jerk(nb::module_& m) {
  using F = WhiteJerk<V>;
  auto c = bind_factor<F>(m);
  bind_stepped_motion(c);
  bind_odometry(c);
  c.def_static("continuous", &F::continuous, "duration"_a, "q"_a, "q: density of the jerk [m²/s⁵]")
      .def("merged", &F::merged, "m"_a, "one factor for m times as many steps");
}

template <class V>
void bind_huber_measurement(nb::module_& m) {
  using F = HuberMeasurement<V>;
  using z = typename F::Measurement;
  using Q = Matrix<z::RowsAtCompileTime, z::RowsAtCompileTime>;
  bind_factor<F>(m).def_static(
      "of_position",
      [](nb::handle measured, nb::handle p_agent, nb::handle covariance, double weight) {
        return F::of_position(numbers<z>("z", measured), numbers<z>("p_agent", p_agent), numbers<Q>("Q", covariance), weight);
      },
      "z"_a, "p_agent"_a, "Q"_a, "weight"_a = 1.0);
}

template <class S, class E>
void bind_huber_edge(nb::module_& m) {
  using F = HuberMeasurementEdge<S, E>;
  using z = typename F::Measurement;
  using Q = Matrix<z::RowsAtCompileTime, z::RowsAtCompileTime>;
  bind_factor<F>(m).def_static(
      "of_position",
      [](nb::handle measured, nb::handle covariance, double weight) {
        return F::of_position(numbers<z>("z", measured), numbers<Q>("Q", covariance), weight);
      },
      "z"_a, "Q"_a, "weight"_a = 1.0, "z = p_s − p_e");
}

}  // namespace

void bind_motion_factors(nb::module_& m) {
  bind_white_acceleration<Motion2>(m);
  bind_white_acceleration<Motion3>(m);
  bind_white_jerk<Accel2>(m);
  bind_white_jerk<Accel3>(m);
  bind_factor<ConstantTurn<Motion2>>(m).def_static(
      "from_covariance",
      [](double dt, double omega, nb::handle covariance) {
        return ConstantTurn<Motion2>::from_covariance(dt, omega, numbers<Matrix<4, 4>>("covariance", covariance));
      },
      "dt"_a, "omega"_a, "covariance"_a);
  auto turn = bind_factor<CoordinatedTurn>(m);
  bind_motion(turn);
  bind_huber_measurement<Point2>(m);
  bind_huber_measurement<Point3>(m);
  bind_huber_measurement<Motion2>(m);
  bind_huber_measurement<Motion3>(m);
  bind_huber_edge<Point2, Point2>(m);
  bind_huber_edge<Point3, Point3>(m);
  bind_huber_edge<Motion2, Motion2>(m);
  bind_huber_edge<Motion3, Motion3>(m);
}

}  // namespace holdfast::python
