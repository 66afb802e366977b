#include <algorithm>
#include <cctype>
#include <filesystem>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/internal/text.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <limits>
#include <map>
#include <system_error>

namespace holdfast {
namespace {

struct Posed {
  Key key;
  VertexValue value;
};

Pose3 in_space(const Pose2& pose) {
  const double half = 0.5 * pose.angle();
  return {{pose.p[0], pose.p[1], 0}, Pose3::Rotation(std::cos(half), 0, 0, std::sin(half))};
}
Pose3 in_space(const Pose3& pose) { return pose; }
Pose3 in_space(const Point2& point) { return {{point.value[0], point.value[1], 0}, Pose3::Rotation::Identity()}; }
Pose3 in_space(const Point3& point) { return {point.value, Pose3::Rotation::Identity()}; }

template <class V>
void collect(const Values& values, std::map<Agent, std::vector<Posed>>& agents) {
  for (const auto& pool : values.pools()) {
    if (pool->type() != typeid(V)) continue;
    for (Key key : pool->keys()) agents[key.agent()].push_back({key, values.at<V>(key)});
  }
}

std::vector<StampedValue> stamped(std::vector<Posed> poses, const std::unordered_map<Key, double>& times) {
  std::sort(poses.begin(), poses.end(), [](const Posed& a, const Posed& b) { return a.key < b.key; });
  const auto has_time = [&](const Posed& pose) { return times.count(pose.key) != 0; };
  const bool any = std::any_of(poses.begin(), poses.end(), has_time);
  const auto missing = std::find_if_not(poses.begin(), poses.end(), has_time);
  if (any && missing != poses.end())
    fail<BadFile>("cannot write a TUM file: ", missing->key.str(), " has no time stamp, others of its agent have; give all or none");
  std::vector<StampedValue> trajectory;
  for (const Posed& pose : poses) trajectory.push_back({any ? times.at(pose.key) : static_cast<double>(pose.key.step()), pose.value});
  std::stable_sort(trajectory.begin(), trajectory.end(), [](const StampedValue& a, const StampedValue& b) { return a.time < b.time; });
  constexpr double kLater = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    if (!(trajectory[i].time > trajectory[i - 1].time)) trajectory[i].time = std::nextafter(trajectory[i - 1].time, kLater);
  return trajectory;
}

std::string file_name(Agent agent) {
  const unsigned char code = static_cast<unsigned char>(agent.kind());
  if (std::isalnum(code) && !std::isdigit(code)) return agent.str() + ".tum";
  const std::string number = agent.number() > 0 ? "_" + std::to_string(agent.number()) : "";
  return "agent_" + std::to_string(code) + number + ".tum";
}

}  // namespace

std::string to_tum(const std::vector<StampedValue>& trajectory) {
  io::Text text;
  for (const StampedValue& stamp : trajectory) {
    const Pose3 pose = std::visit([](const auto& value) { return in_space(value); }, stamp.value);
    text.number(stamp.time).number(pose.p[0]).number(pose.p[1]).number(pose.p[2]);
    text.number(pose.q.x()).number(pose.q.y()).number(pose.q.z()).number(pose.q.w());
    text.end_line();
  }
  return text.take();
}

void write_tum(const std::string& path, const std::vector<StampedValue>& trajectory) { atomic_write(path, to_tum(trajectory)); }

std::unordered_map<Key, double> vertex_times(const Dataset& dataset) {
  std::unordered_map<Key, double> times;
  for (const Vertex& vertex : dataset.vertices)
    if (vertex.time) times.emplace(vertex.key, *vertex.time);
  return times;
}

std::vector<std::string> write_tum_directory(const std::string& directory, const Values& values,
                                             const std::unordered_map<Key, double>& times) {
  std::map<Agent, std::vector<Posed>> agents;
  collect<Pose2>(values, agents);
  collect<Pose3>(values, agents);
  std::vector<std::pair<std::string, std::string>> files;  // all texts before the first file: a bad number writes none
  for (auto& [agent, poses] : agents)
    files.emplace_back((std::filesystem::path(directory) / file_name(agent)).string(), to_tum(stamped(std::move(poses), times)));

  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) fail<BadFile>("cannot make the directory ", directory, ": ", error.message());
  std::vector<std::string> paths;
  for (const auto& [path, text] : files) {
    atomic_write(path, text);
    paths.push_back(path);
  }
  return paths;
}

}  // namespace holdfast
