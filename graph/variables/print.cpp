#include <holdfast/graph/variables/print.hpp>
#include <locale>
#include <sstream>

namespace holdfast {

std::ostream& detail::print_numbers(std::ostream& out, const char* name, const double* x, int n) {
  std::ostringstream text;  // whatever the stream's own locale and precision
  text.imbue(std::locale::classic());
  text << name << "(";
  for (int i = 0; i < n; ++i) text << (i == 0 ? "" : ", ") << x[i];
  return out << text.str() << ")";
}

std::ostream& operator<<(std::ostream& out, const Scalar& x) { return detail::print_numbers(out, x.name(), &x.value, 1); }

std::ostream& operator<<(std::ostream& out, const Turning2& x) { return detail::print_numbers(out, x.name(), x.value.data(), x.dim); }

std::ostream& operator<<(std::ostream& out, const Pose2& x) {
  const double numbers[]{x.p[0], x.p[1], x.angle()};
  return detail::print_numbers(out, x.name(), numbers, 3);
}

std::ostream& operator<<(std::ostream& out, const Pose3& x) {
  const Vector<3> angles = x.roll_pitch_yaw();
  const double numbers[]{x.p[0], x.p[1], x.p[2], angles[0], angles[1], angles[2]};
  return detail::print_numbers(out, x.name(), numbers, 6);
}

}  // namespace holdfast
