#include <holdfast/graph/error.hpp>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/solvers/distributed/internal/directory.hpp>

namespace holdfast::detail {
namespace {

std::vector<std::vector<Key>> by_hash(const std::vector<Key>& keys, int size) {
  std::vector<std::vector<Key>> lists(size);
  for (Key key : keys) lists[std::hash<Key>()(key) % size].push_back(key);
  return lists;
}

template <class T>
std::vector<std::string> as_bytes(const std::vector<std::vector<T>>& lists) {
  std::vector<std::string> bytes;
  for (const std::vector<T>& list : lists) bytes.emplace_back(reinterpret_cast<const char*>(list.data()), list.size() * sizeof(T));
  return bytes;
}

template <class T>
std::vector<T> as_list(const std::string& bytes) {
  std::vector<T> list(bytes.size() / sizeof(T));
  if (!list.empty()) std::memcpy(static_cast<void*>(list.data()), bytes.data(), bytes.size());
  return list;
}

}  // namespace

Directory::Directory(const Communicator& communicator, const std::vector<Key>& own) : communicator_(communicator) {
  const std::vector<std::string> entries = communicator.exchange(as_bytes(by_hash(own, communicator.size())));
  communicator.agree([&] {
    for (int rank = 0; rank < communicator.size(); ++rank)
      for (Key key : as_list<Key>(entries[rank])) {
        const auto [entry, is_new] = entries_.emplace(key, rank);
        if (!is_new)
          fail<BadKey>("processes ", entry->second, " and ", rank, " both have the variable ", key,
                       "; each variable belongs to one, and the others name its key only");
      }
  });
}

std::vector<int> Directory::owners(const std::vector<Key>& keys) const {
  const int size = communicator_.size();
  const std::vector<std::string> asked = communicator_.exchange(as_bytes(by_hash(keys, size)));
  std::vector<std::vector<int>> answers(size);
  for (int rank = 0; rank < size; ++rank)
    for (Key key : as_list<Key>(asked[rank])) {
      const auto entry = entries_.find(key);
      answers[rank].push_back(entry == entries_.end() ? -1 : entry->second);
    }
  const std::vector<std::string> answered = communicator_.exchange(as_bytes(answers));
  std::vector<std::vector<int>> lists(size);
  for (int rank = 0; rank < size; ++rank) lists[rank] = as_list<int>(answered[rank]);
  std::vector<std::size_t> next(size, 0);
  std::vector<int> owners;
  for (Key key : keys) {
    const std::size_t rank = std::hash<Key>()(key) % size;
    owners.push_back(lists[rank][next[rank]++]);
  }
  return owners;
}

}  // namespace holdfast::detail
