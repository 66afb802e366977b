// Uses an installed holdfast: two poses, one moved along its tangent.
#include <cmath>
#include <cstdio>
#include <holdfast/graph/values.hpp>

using namespace holdfast;

int main() {
  constexpr Agent A('A');
  Values values;
  values.insert(A(0), Pose2());
  values.insert(A(1), Pose2().retract(Vector<3>(1.0, 2.0, M_PI / 2)));

  const Vector<3> step = values.at<Pose2>(A(0)).local(values.at<Pose2>(A(1)));
  const bool right = values.size() == 2 && (step - Vector<3>(1.0, 2.0, M_PI / 2)).norm() < 1e-12;

  bool named = false;
  try {
    values.at<Pose2>(A(7));
  } catch (const BadKey& error) {
    named = std::string(error.what()).find("A7") != std::string::npos;
  }
  std::printf("consumer: %s\n", right && named ? "ok" : "WRONG");
  return right && named ? 0 : 1;
}
