// Back-ends by their names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/solvers/table.hpp>

namespace holdfast {
namespace {

using ::testing::HasSubstr;

/// Finds nothing at all.
class Idle final : public Backend {
 public:
  explicit Idle(std::string name, Options chosen = {}) : Backend(std::move(chosen)), name_(std::move(name)) {}
  std::string name() const override { return name_; }

 protected:
  Summary minimize(const Graph&, Values&) override { return {}; }

 private:
  std::string name_;
};

BackendFactory idle(const std::string& name) {
  return [name](const Options& options) { return std::make_unique<Idle>(name, options); };
}

TEST(BackendNames, HoldTheInHouseOnesInOrder) {
  const std::vector<std::string> names = backend_names();
  EXPECT_THAT(names, ::testing::IsSupersetOf({"irls", "nesterov"}));
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
}

TEST(MakeBackend, GivesTheOneOfThatNameWithTheOptions) {
  Options options;
  options.max_iterations = 17;
  for (const std::string name : {"irls", "nesterov"}) {
    const auto backend = make_backend(name, options);
    EXPECT_EQ(backend->name(), name);
    EXPECT_EQ(backend->options.max_iterations, 17);
  }
}

TEST(MakeBackend, ListsTheNamesWhereOneIsUnknown) {
  try {
    make_backend("gauss");
    FAIL();
  } catch (const BadOption& error) {
    EXPECT_THAT(error.what(), HasSubstr("gauss"));
    for (const std::string& name : backend_names()) EXPECT_THAT(error.what(), HasSubstr(name));
  }
}

TEST(RegisterBackend, TakesAUsersOwnAndTheLastOfTwoCounts) {
  register_backend("idle", idle("first"));
  EXPECT_THAT(backend_names(), ::testing::Contains("idle"));
  EXPECT_EQ(make_backend("idle")->name(), "first");
  register_backend("idle", idle("second"));
  EXPECT_EQ(make_backend("idle")->name(), "second");
}

}  // namespace
}  // namespace holdfast
