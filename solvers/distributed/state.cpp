#include <algorithm>
#include <filesystem>
#include <fstream>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/solvers/distributed/internal/distributed_problem.hpp>
#include <holdfast/solvers/distributed/state.hpp>
#include <sstream>

namespace holdfast {
namespace {

constexpr std::string_view kMagic = "holdfast distributed state";
constexpr std::uint32_t kVersion = 1;

struct Part {
  std::uint32_t job = 0;
  std::uint32_t iteration = 0;
  Values values;
};

Part read_part(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  content << file.rdbuf();
  if (!file) fail<BadFile>(path.string(), ": it cannot be read");
  const std::string bytes = content.str();
  try {
    io::ByteReader in(bytes);
    if (in.get_text() != kMagic) fail<BadFile>("it is no state of a distributed solve");
    if (const auto version = in.get<std::uint32_t>(); version != kVersion)
      fail<BadFile>("its version is ", version, ", and this program reads ", kVersion);
    Part part;
    part.job = in.get<std::uint32_t>();
    part.iteration = in.get<std::uint32_t>();
    Graph none;
    io::read_binary(in, none, part.values);
    return part;
  } catch (const BadFile& error) {
    fail<BadFile>(path.string(), ": ", error.what(), "; remove it, or name another directory");
  }
}

std::vector<std::filesystem::path> parts_in(const std::string& directory) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    if (entry.path().extension() == ".state") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace

void save_state(const DistributedGraph& graph, const std::string& directory, int iteration) {
  Values own;
  for (const auto& pool : graph.values().pools())
    for (int i = 0; i < pool->size(); ++i)
      if (graph.is_own(pool->keys()[i])) own.insert_ambient(pool->keys()[i], pool->kind(), std::as_const(*pool).data(i));
  io::ByteWriter out;
  out.put(kMagic).put(kVersion).put<std::uint32_t>(graph.job()).put<std::uint32_t>(iteration);
  io::write_binary(out, Graph(), own);
  atomic_write(directory + "/part-" + std::to_string(graph.communicator().rank()) + ".state", out.bytes());
}

std::int64_t load_state(DistributedGraph& graph, const std::string& directory) {
  struct Newest {
    std::uint64_t when = 0;
    bool found = false;
  };
  std::unordered_map<Key, Newest> newest;
  std::uint32_t last_job = 0;
  const Communicator& all = graph.communicator();
  all.agree([&] {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) fail<BadFile>(directory, ": ", error.message());
    for (const std::filesystem::path& path : parts_in(directory)) {
      const Part part = read_part(path);
      last_job = std::max(last_job, part.job);
      const std::uint64_t when = (static_cast<std::uint64_t>(part.job) << 32) | part.iteration;
      for (const auto& pool : part.values.pools())
        for (int i = 0; i < pool->size(); ++i) {
          const Key key = pool->keys()[i];
          if (!graph.is_own(key)) continue;
          Newest& so_far = newest[key];
          if (so_far.found && so_far.when >= when) continue;
          const Values::Slot slot = graph.values().slot(key);
          PoolBase& mine = graph.values().pool(slot.pool);
          if (mine.type() != pool->type())
            fail<BadFile>(path.string(), ": ", key, " is a ", pool->type_name(), " there and a ", mine.type_name(), " here");
          std::copy_n(std::as_const(*pool).data(i), pool->ambient(), mine.data(slot.index));
          so_far = {when, true};
        }
    }
  });
  graph.set_job(static_cast<std::uint32_t>(all.max(last_job)) + 1);
  detail::DistributedProblem(graph, false).update(graph.values());
  return all.sum(static_cast<std::int64_t>(newest.size()));
}

}  // namespace holdfast
