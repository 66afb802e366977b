#include <algorithm>
#include <atomic>
#include <holdfast/graph/values.hpp>
#include <map>
#include <string>

namespace holdfast {
namespace {

std::map<std::string, const PoolBase*, std::less<>>& variable_types() {
  static std::map<std::string, const PoolBase*, std::less<>> types;
  return types;
}

}  // namespace

bool enter_variable_type(const PoolBase& prototype) { return variable_types().emplace(prototype.type_name(), &prototype).second; }

const PoolBase* find_variable_type(std::string_view name) {
  const auto it = variable_types().find(name);
  return it == variable_types().end() ? nullptr : it->second;
}

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
  spare_ = std::move(other.spare_);
  other.spare_.clear();
  other.structure_ = new_structure_stamp();
  return *this;
}

Values& Values::operator=(const Values& other) {
  if (this == &other) return *this;
  const auto same_type = [](const auto& a, const auto& b) { return a->type() == b->type(); };
  if (structure_ == other.structure_)
    assign(other);
  else if (std::equal(pools_.begin(), pools_.end(), other.pools_.begin(), other.pools_.end(), same_type))
    take_structure(other);
  else
    *this = Values(other);
  return *this;
}

// Other keys of the same types: in the memory that is there.
void Values::take_structure(const Values& other) {
  for (const auto& pool : pools_)
    for (Key key : pool->keys_)
      if (!other.contains(key)) forget(key);
  for (std::size_t p = 0; p < pools_.size(); ++p) {
    pools_[p]->assign(*other.pools_[p]);
    pools_[p]->keys_ = other.pools_[p]->keys_;
    for (int i = 0; i < pools_[p]->size(); ++i) place(pools_[p]->keys_[i], {static_cast<int>(p), i});
  }
  structure_ = other.structure_;
}

void Values::assign(const Values& other) {
  for (std::size_t i = 0; i < pools_.size(); ++i) pools_[i]->assign(*other.pools_[i]);
}

void Values::require_new(Key key) const {
  const auto it = slots_.find(key);
  if (it != slots_.end())
    fail<BadKey>("key ", key, " is in the values already, as a ", pools_[it->second.pool]->type_name(), "; use update() to change it");
}

int Values::pool_of(const PoolBase& type) {
  for (std::size_t i = 0; i < pools_.size(); ++i)
    if (pools_[i]->type() == type.type()) return static_cast<int>(i);
  pools_.push_back(type.clone());
  return static_cast<int>(pools_.size()) - 1;
}

void Values::claim(Key key, int pool) {
  place(key, {pool, pools_[pool]->size()});
  structure_ = new_structure_stamp();
}

void Values::place(Key key, const Slot& slot) {
  const auto it = slots_.find(key);
  if (it != slots_.end()) {
    it->second = slot;
  } else if (spare_.empty()) {
    slots_.emplace(key, slot);
  } else {
    Slots::node_type node = std::move(spare_.back());
    spare_.pop_back();
    node.key() = key;
    node.mapped() = slot;
    slots_.insert(std::move(node));
  }
}

void Values::insert_ambient(Key key, const PoolBase& type, const double* x) {
  require_new(key);
  const int pool = pool_of(type);
  claim(key, pool);
  pools_[pool]->push_ambient(key, x);
}

void Values::forget(Key key) { spare_.push_back(slots_.extract(key)); }

void Values::erase(Key key) {
  const Slot gone = slot(key);
  PoolBase& pool = *pools_[gone.pool];
  slots_.find(pool.keys_.back())->second.index = gone.index;
  forget(key);
  pool.remove(gone.index);
  structure_ = new_structure_stamp();
}

void Values::erase(const std::vector<Key>& keys) {
  for (Key key : keys) slot(key);
  for (std::size_t p = 0; p < pools_.size(); ++p) {
    PoolBase& pool = *pools_[p];
    gone_.assign(pool.size(), 0);
    for (Key key : keys) {
      const auto it = slots_.find(key);
      if (it == slots_.end() || it->second.pool != static_cast<int>(p)) continue;
      gone_[it->second.index] = 1;
      forget(key);
    }
    const auto first = std::find(gone_.begin(), gone_.end(), 1);
    if (first == gone_.end()) continue;
    const int unmoved = static_cast<int>(first - gone_.begin());
    pool.remove(gone_);
    for (int i = unmoved; i < pool.size(); ++i) slots_.find(pool.keys_[i])->second.index = i;
  }
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
  if (pool.type() != type)
    fail<BadType>("key ", key, " is a ", pool.type_name(), ", not a ", type_name, "; ask for it as a ", pool.type_name());
  return it->second;
}

}  // namespace holdfast
