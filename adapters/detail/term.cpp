#include <cmath>
#include <holdfast/adapters/detail/term.hpp>

namespace holdfast {
namespace {

bool are_near(const double* a, const double* b, std::size_t n, double tolerance) {
  for (std::size_t i = 0; i < n; ++i)
    if (!(std::abs(a[i] - b[i]) <= tolerance)) return false;
  return true;
}
bool are_near(const std::vector<double>& a, const std::vector<double>& b, double tolerance) {
  return a.size() == b.size() && are_near(a.data(), b.data(), a.size(), tolerance);
}

bool are_near(const Loss& a, const Loss& b, double tolerance) {
  return a == b || (a.kind != Loss::Kind::Own && a.is_of_family(b) && std::abs(a.scale - b.scale) <= tolerance);
}

bool are_near(const LinearPrior& a, const LinearPrior& b, double tolerance) {
  return a.types == b.types && a.rows == b.rows && are_near(a.x0, b.x0, tolerance) && are_near(a.A, b.A, tolerance) &&
         are_near(a.b, b.b, tolerance);
}

/// Of two batches of one type: factors i and j, field by field.
bool have_near_fields(const FactorType& type, const FactorBatch& a, int i, const FactorBatch& b, int j, double tolerance) {
  std::size_t bytes = 0;
  for (const FieldType& field : type.fields) bytes += field.bytes;
  std::vector<char> of_a(bytes), of_b(bytes);
  type.put(a, i, of_a.data());
  type.put(b, j, of_b.data());
  std::size_t at = 0;
  for (const FieldType& field : type.fields) {
    const char *x = of_a.data() + at, *y = of_b.data() + at;
    at += field.bytes;
    if (std::memcmp(x, y, field.bytes) == 0) continue;
    if (!field.in_doubles) return false;
    std::vector<double> of_x(field.bytes / sizeof(double)), of_y(of_x.size());
    std::memcpy(of_x.data(), x, field.bytes);
    std::memcpy(of_y.data(), y, field.bytes);
    if (!are_near(of_x, of_y, tolerance)) return false;
  }
  return true;
}

}  // namespace

bool Term::equals(const Term& other, double tolerance) const {
  const FactorBatch &a = batch(), &b = other.batch();
  if (a.factor_type() != b.factor_type() || !are_near(loss(), other.loss(), tolerance) ||
      !(std::abs(weight() - other.weight()) <= tolerance))
    return false;
  if (&a == &b && index_ == other.index_) return true;
  if (const auto* prior = dynamic_cast<const LinearPriorBatch*>(&a))
    return are_near(prior->prior(), static_cast<const LinearPriorBatch&>(b).prior(), tolerance);
  const FactorType* type = find_factor_type(a.factor_type());
  return type != nullptr && !type->fields.empty() && have_near_fields(*type, a, index_, b, other.index_, tolerance);
}

void Term::require_type() const {
  fail<BadOption>(batch_->describe(index_), " went without its type and cannot come back; keep the graph it came from");
}

}  // namespace holdfast
