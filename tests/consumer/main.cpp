// A stranger's program on an installed holdfast: two poses and a range, solved, with the covariance of one of them.
#include <cmath>
#include <cstdio>
#include <holdfast/holdfast.hpp>
#include <string>

using namespace holdfast;

int main() {
  constexpr Agent A('A');
  Graph graph;
  graph.add(Prior<Pose2>::from_sigmas(Pose2(), Vector<3>(0.1, 0.1, 0.1)), {A(0)});
  graph.add(Between<Pose2>::from_sigmas(Pose2(1, 2, M_PI / 2), Vector<3>(0.1, 0.1, 0.1)), {A(0), A(1)});
  graph.add(Range<Pose2, Pose2>{std::sqrt(5.0), 0.1}, {A(0), A(1)}, Huber{2});
  Values values;
  values.insert(A(0), Pose2(0.3, -0.2, 0.1));
  values.insert(A(1), Pose2(0.5, 1.0, 1.0));
  const Summary summary = make_backend("irls")->solve(graph, values);
  const Vector<3> step = values.at<Pose2>(A(1)).local(Pose2(1, 2, M_PI / 2));
  const double sigma = std::sqrt(Marginals(graph, values).covariance<Pose2>(A(0))(0, 0));

  bool named = false;
  try {
    values.at<Pose2>(A(7));
  } catch (const BadKey& error) {
    named = std::string(error.what()).find("A7") != std::string::npos;
  }
  const bool right = summary.usable() && step.norm() < 1e-6 && std::abs(sigma - 0.1) < 1e-9;
  std::printf("consumer: %s\n", right && named ? "ok" : "WRONG");
  return right && named ? 0 : 1;
}
