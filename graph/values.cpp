#include <algorithm>
#include <atomic>
#include <holdfast/graph/values.hpp>

namespace holdfast {

std::uint64_t new_structure_stamp() {
  static std::atomic<std::uint64_t> next{1};
  return next++;
}

Values::Values() : structure_(new_structure_stamp()) {}

Values::Values(const Values& other) : slots_(other.slots_), structure_(other.structure_) {
  for (const auto& pool : other.pools_) pools_.push_back(pool->clone());
}

// What is left behind is empty, and has another structure than what was taken.
Values::Values(Values&& other) noexcept : Values() { *this = std::move(other); }

Values& Values::operator=(Values&& other) noexcept {
  if (this == &other) return *this;
  pools_ = std::move(other.pools_);
  slots_ = std::move(other.slots_);
  structure_ = other.structure_;
  other.pools_.clear();
  other.slots_.clear();
  other.structure_ = new_structure_stamp();
  return *this;
}

Values& Values::operator=(const Values& other) {
  if (this == &other) return *this;
  if (structure_ == other.structure_)
    assign(other);
  else
    *this = Values(other);
  return *this;
}

void Values::assign(const Values& other) {
  for (std::size_t i = 0; i < pools_.size(); ++i) pools_[i]->assign(*other.pools_[i]);
}

void Values::require_new(Key key) const {
  const auto it = slots_.find(key);
  if (it != slots_.end())
    fail<BadKey>("key ", key, " is in the values already, as a ", pools_[it->second.pool]->type_name(), "; use update() to change it");
}

void Values::claim(Key key, PoolBase& pool) {
  const auto it = std::find_if(pools_.begin(), pools_.end(), [&](const auto& p) { return p.get() == &pool; });
  const Slot slot{static_cast<int>(it - pools_.begin()), pool.size()};
  slots_.emplace(key, slot);
  pool.keys_.push_back(key);
  structure_ = new_structure_stamp();
}

void Values::erase(Key key) {
  const Slot gone = slot(key);
  PoolBase& pool = *pools_[gone.pool];
  slots_[pool.keys_.back()].index = gone.index;
  slots_.erase(key);
  pool.remove(gone.index);
  structure_ = new_structure_stamp();
}

std::vector<Key> Values::keys() const {
  std::vector<Key> all;
  all.reserve(size());
  for (const auto& pool : pools_) all.insert(all.end(), pool->keys_.begin(), pool->keys_.end());
  std::sort(all.begin(), all.end());
  return all;
}

const Values::Slot& Values::slot(Key key) const {
  const auto it = slots_.find(key);
  if (it == slots_.end()) fail<BadKey>("key ", key, " is not in the values; insert it before it is used");
  return it->second;
}

const Values::Slot& Values::checked(Key key, std::type_index type, const char* type_name) const {
  const auto it = slots_.find(key);
  if (it == slots_.end()) fail<BadKey>("key ", key, " (a ", type_name, ") is not in the values; insert it before it is used");
  const PoolBase& pool = *pools_[it->second.pool];
  if (pool.type() != type) fail<BadType>("key ", key, " is a ", pool.type_name(), ", not a ", type_name, "; ask for it as a ", pool.type_name());
  return it->second;
}

}  // namespace holdfast
