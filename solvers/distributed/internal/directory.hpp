// Who owns which key: a table spread over the processes by the keys' hash, so that none holds the whole. Internal.
#pragma once

#include <holdfast/graph/key.hpp>
#include <holdfast/solvers/distributed/communicator.hpp>
#include <unordered_map>

namespace holdfast::detail {

class Directory {
 public:
  /// Collective, as all here. Throws BadKey where two processes own a key.
  Directory(const Communicator& communicator, const std::vector<Key>& own);
  /// The rank of the owner of each; −1: nobody.
  std::vector<int> owners(const std::vector<Key>& keys) const;

 private:
  const Communicator& communicator_;
  std::unordered_map<Key, int> entries_;  // of the keys whose hash is ours
};

}  // namespace holdfast::detail
