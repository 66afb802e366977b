// A back-end by its name, "irls" with Newton's curvature of robust terms: few iterations to the last digit.
#pragma once

#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {

inline std::unique_ptr<Backend> newton_backend(const std::string& name, const Options& options) {
  if (name == "irls") return std::make_unique<Irls>(options, IrlsOptions{Reweighting::newton});
  return make_backend(name, options);
}

}  // namespace holdfast::bench
