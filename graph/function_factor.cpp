#include <cmath>
#include <holdfast/graph/function_factor.hpp>
#include <limits>

namespace holdfast {
namespace {

/// The batch whose function this thread is in.
thread_local const FunctionBatch* evaluating = nullptr;

/// Locks a batch for this thread; refuses a function that evaluates its own factors, which would wait for itself for ever.
class Entered {
 public:
  Entered(const FunctionBatch* batch, std::mutex& mutex) : before_(evaluating) {
    if (evaluating == batch) fail<BadOption>(batch->name(), ": the function evaluates its own factors; it may look at other graphs only");
    lock_ = std::unique_lock<std::mutex>(mutex);
    evaluating = batch;
  }
  ~Entered() { evaluating = before_; }
  Entered(const Entered&) = delete;
  Entered& operator=(const Entered&) = delete;

 private:
  const FunctionBatch* before_;
  std::unique_lock<std::mutex> lock_;
};

}  // namespace

void FunctionFactors::validate() const {
  if (types.empty()) fail<BadOption>("FunctionFactors ", name, ": types is empty; name the variables, such as &Pool<Pose2>::prototype()");
  if (residual_dim < 1) fail<BadOption>("FunctionFactors ", name, ": residual_dim = ", residual_dim, ", must be > 0");
  if (!evaluate) fail<BadOption>("FunctionFactors ", name, ": there is no function; set evaluate");
}

FunctionBatch::FunctionBatch(std::shared_ptr<const FunctionFactors> function, const Loss& loss)
    : FactorBatch(function->name, typeid(FunctionFactors), loss), function_(std::move(function)) {
  for (const PoolBase* type : function_->types) {
    types_.push_back(type->type());
    type_names_.push_back(type->type_name());
    dims_.push_back(type->dim());
    ambient_ += type->ambient();
  }
  set_sizes(function_->residual_dim);
}

FunctionBatch::FunctionBatch(const FunctionBatch& other)
    : FactorBatch(other), function_(other.function_), numbers_(other.numbers_), ambient_(other.ambient_) {}

bool FunctionBatch::takes_factors_of(const FactorBatch& other) const {
  const auto* functions = dynamic_cast<const FunctionBatch*>(&other);
  return functions != nullptr && functions->function_ == function_;
}

std::string FunctionBatch::take_error() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(error_, std::string());
}

void FunctionBatch::erase(int i) {
  numbers_[i] = numbers_.back();
  numbers_.pop_back();
  x_.clear();
}

void FunctionBatch::evaluate(const Values& values, const int* index, int first, int last, double* r, double* J) const {
  if (first >= last) return;
  std::vector<const PoolBase*> pools;
  for (const PoolBase* type : function_->types)
    for (const auto& pool : values.pools())
      if (pool->type() == type->type()) pools.push_back(pool.get());
  const auto gather = [&](int from, int to, double* x) {
    for (int i = from; i < to; ++i)
      for (int k = 0; k < arity(); ++k) {
        const double* data = pools[k]->data(index[static_cast<std::size_t>(i) * arity() + k]);
        x = std::copy_n(data, pools[k]->ambient(), x);
      }
  };
  const std::size_t m = static_cast<std::size_t>(residual_dim()), n = static_cast<std::size_t>(size()), width = m * total_dim();
  const Entered entered(this, mutex_);
  std::vector<double> here(static_cast<std::size_t>(last - first) * ambient_);
  gather(first, last, here.data());
  const bool is_known = x_.size() == n * ambient_ && (J == nullptr || has_J_) &&
                        std::equal(here.begin(), here.end(), x_.begin() + static_cast<std::ptrdiff_t>(first) * ambient_);
  if (!is_known) {
    x_.resize(n * ambient_);
    r_.resize(n * m);
    J_.resize(J == nullptr ? 0 : n * width);
    gather(0, size(), x_.data());
    compute(size(), numbers_.data(), x_.data(), r_.data(), J == nullptr ? nullptr : J_.data());
    has_J_ = J != nullptr;
    if (!error_.empty()) x_.clear();  // it may go better next time
  }
  std::copy_n(r_.begin() + static_cast<std::ptrdiff_t>(first * m), static_cast<std::size_t>(last - first) * m, r);
  if (J != nullptr) std::copy_n(J_.begin() + static_cast<std::ptrdiff_t>(first * width), static_cast<std::size_t>(last - first) * width, J);
}

void FunctionBatch::evaluate_at(int i, const double* const* ambient, double* r, double* J) const {
  std::vector<double> x;
  for (int k = 0; k < arity(); ++k) x.insert(x.end(), ambient[k], ambient[k] + function_->types[k]->ambient());
  const Entered entered(this, mutex_);
  compute(1, &numbers_[i], x.data(), r, J);
}

void FunctionBatch::compute(int n, const int* numbers, const double* x, double* r, double* J) const {
  std::vector<std::vector<double>> parts(arity()), jacobians;
  double* const J_begin = J;
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < arity(); ++k) {
      const int ambient = function_->types[k]->ambient();
      parts[k].insert(parts[k].end(), x, x + ambient);
      x += ambient;
    }
  try {
    if (J == nullptr || !function_->has_jacobian) {
      call(n, numbers, parts, r, nullptr);
      if (J != nullptr) differences(n, numbers, parts, J);
      return;
    }
    call(n, numbers, parts, r, &jacobians);
    const int m = residual_dim();
    for (int i = 0; i < n; ++i)  // row by row and variable by variable → column by column
      for (int k = 0; k < arity(); ++k)
        for (int c = 0; c < dims()[k]; ++c)
          for (int row = 0; row < m; ++row) *J++ = jacobians[k][(static_cast<std::size_t>(i) * m + row) * dims()[k] + c];
  } catch (const std::exception& error) {
    if (error_.empty()) error_ = error.what();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::fill_n(r, static_cast<std::size_t>(n) * residual_dim(), nan);
    if (J_begin != nullptr) std::fill_n(J_begin, static_cast<std::size_t>(n) * residual_dim() * total_dim(), nan);
  }
}

void FunctionBatch::call(int n, const int* numbers, const std::vector<std::vector<double>>& x, double* r,
                         std::vector<std::vector<double>>* J) const {
  FunctionCall call;
  call.n = n;
  call.number = numbers;
  call.r = r;
  for (const std::vector<double>& part : x) call.x.push_back(part.data());
  if (J != nullptr) {
    J->resize(x.size());
    for (int k = 0; k < arity(); ++k) {
      (*J)[k].assign(static_cast<std::size_t>(n) * residual_dim() * dims()[k], 0);
      call.J.push_back((*J)[k].data());
    }
  }
  function_->evaluate(call);
}

void FunctionBatch::differences(int n, const int* numbers, std::vector<std::vector<double>>& x, double* J) const {
  constexpr double h = 1e-6;
  const int m = residual_dim();
  const std::size_t stride = static_cast<std::size_t>(m) * total_dim();
  std::vector<double> ahead(static_cast<std::size_t>(n) * m), behind(ahead.size());
  int column = 0;
  for (int k = 0; k < arity(); ++k) {
    const PoolBase& type = *function_->types[k];
    const std::vector<double> at = x[k];
    std::vector<double> delta(type.dim(), 0);
    for (int c = 0; c < type.dim(); ++c, ++column) {
      for (std::vector<double>* to : {&ahead, &behind}) {
        delta[c] = to == &ahead ? h : -h;
        for (int i = 0; i < n; ++i) {
          const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(i) * type.ambient();
          type.retract_ambient(at.data() + offset, delta.data(), x[k].data() + offset);
        }
        call(n, numbers, x, to->data(), nullptr);
      }
      delta[c] = 0;
      for (int i = 0; i < n; ++i)
        for (int row = 0; row < m; ++row) {
          const std::size_t entry = static_cast<std::size_t>(i) * m + row;
          J[i * stride + static_cast<std::size_t>(column) * m + row] = (ahead[entry] - behind[entry]) / (2 * h);
        }
    }
    x[k] = at;
  }
}

}  // namespace holdfast
