// Python functions as factors: graph/function_factor.hpp with NumPy arrays.
#include <atomic>
#include <holdfast/graph/detail/evaluation_error.hpp>
#include <holdfast/graph/function_factor.hpp>
#include <holdfast/graph/variables.hpp>
#include <map>

#include "own_loss.hpp"

namespace holdfast::python {
namespace {

template <class... V>
const PoolBase* prototype_of(nb::handle type) {
  const PoolBase* found = nullptr;
  (void)((type.is(nb::type<V>()) && (found = &Pool<V>::prototype(), true)) || ...);
  return found;
}

/// A copy as a NumPy array: Python may keep it.
template <class T>
nb::object array(const T* from, std::initializer_list<std::size_t> shape) {
  std::size_t size = 1;
  for (const std::size_t n : shape) size *= n;
  T* data = new T[size];
  std::copy_n(from, size, data);
  const nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(data, shape.size(), shape.begin(), owner));
}

std::string shape_text(const std::vector<std::size_t>& shape) {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i) text += (i > 0 ? ", " : "") + std::to_string(shape[i]);
  return text + (shape.size() == 1 ? ",)" : ")");
}

/// Anything that NumPy makes an array of this shape of, into `to`. A dimension of 1 may be left out.
void take(const char* what, nb::handle given, const std::vector<std::size_t>& shape, double* to) {
  std::size_t size = 1;
  for (const std::size_t n : shape) size *= n;
  const nb::object numpy = nb::module_::import_("numpy");
  const nb::object numbers = numpy.attr("ascontiguousarray")(given, "float64");
  const auto flat = nb::cast<nb::ndarray<const double, nb::c_contig, nb::device::cpu>>(numbers);
  std::vector<std::size_t> is, wanted;
  for (std::size_t d = 0; d < flat.ndim(); ++d)
    if (flat.shape(d) != 1) is.push_back(flat.shape(d));
  for (const std::size_t n : shape)
    if (n != 1) wanted.push_back(n);
  if (is != wanted) {
    std::vector<std::size_t> whole;
    for (std::size_t d = 0; d < flat.ndim(); ++d) whole.push_back(flat.shape(d));
    throw nb::value_error((std::string(what) + " has the shape " + shape_text(whole) + ", must be " + shape_text(shape)).c_str());
  }
  std::copy_n(flat.data(), size, to);
}

/// Ctrl-C within a function: its solve ends as failed, and whoever asked for it raises.
std::atomic<bool> was_interrupted{false};

struct Callee {
  std::shared_ptr<nb::object> function;
  bool has_jacobian, is_vectorized;
  std::size_t m;
  std::vector<const PoolBase*> types;

  void operator()(const FunctionCall& call) const {
    const nb::gil_scoped_acquire gil;
    try {
      if (is_vectorized) return evaluate(call, 0, static_cast<std::size_t>(call.n));
      for (int i = 0; i < call.n; ++i) evaluate(call, static_cast<std::size_t>(i), 1);
    } catch (const nb::python_error& error) {
      note_interrupt(error);
      throw;
    }
  }

 private:
  /// Rows [first, first + n): of one row the arrays have no dimension for it.
  void evaluate(const FunctionCall& call, std::size_t first, std::size_t n) const {
    nb::list arguments;
    if (is_vectorized)
      arguments.append(array(call.number + first, {n}));
    else
      arguments.append(call.number[first]);
    for (std::size_t k = 0; k < types.size(); ++k) {
      const std::size_t ambient = static_cast<std::size_t>(types[k]->ambient());
      const double* x = call.x[k] + first * ambient;
      arguments.append(is_vectorized ? array(x, {n, ambient}) : array(x, {ambient}));
    }
    const nb::object result = (*function)(*arguments);
    if (!has_jacobian) return take_residual(result, call, first, n);
    const nb::sequence parts = nb::cast<nb::sequence>(result);
    if (nb::len(parts) != 1 + types.size())
      throw nb::value_error(("a function with a jacobian returns its residual and " + std::to_string(types.size()) + " Jacobians, not " +
                             std::to_string(nb::len(parts)) + " things")
                                .c_str());
    take_residual(parts[0], call, first, n);
    for (std::size_t k = 0; k < call.J.size(); ++k) {
      const std::size_t dim = static_cast<std::size_t>(types[k]->dim());
      const std::string what = "the Jacobian by variable " + std::to_string(k);
      take(what.c_str(), parts[1 + k], with_rows(n, {m, dim}), call.J[k] + first * m * dim);
    }
  }
  void take_residual(nb::handle given, const FunctionCall& call, std::size_t first, std::size_t n) const {
    take("the residual", given, with_rows(n, {m}), call.r + first * m);
  }
  std::vector<std::size_t> with_rows(std::size_t n, std::vector<std::size_t> shape) const {
    if (is_vectorized) shape.insert(shape.begin(), n);
    return shape;
  }
};

std::vector<FactorId> add_function(Graph& graph, nb::object function, const nb::sequence& types, const std::vector<std::vector<Key>>& keys,
                                   int residual_dim, const Loss& loss, const std::string& name, bool jacobian, bool vectorized) {
  require_unused(&graph, "Graph");
  auto factors = std::make_shared<FunctionFactors>();
  factors->name = name;
  factors->residual_dim = residual_dim;
  factors->has_jacobian = jacobian;
  for (const nb::handle type : types) {
    const PoolBase* pool = prototype_of<Point2, Point3, Motion2, Motion3, Accel2, Accel3, Turning2, Scalar, Pose2, Pose3>(type);
    if (pool == nullptr)
      throw nb::type_error(
          ("types names the variables' classes, such as holdfast.Pose2, not " + nb::cast<std::string>(nb::repr(type))).c_str());
    factors->types.push_back(pool);
  }
  std::vector<Key> flat;
  for (const std::vector<Key>& row : keys) {
    if (row.size() != factors->types.size())
      fail<BadKey>(name, ": a row of ", row.size(), " keys; types has ", factors->types.size(), " variables");
    flat.insert(flat.end(), row.begin(), row.end());
  }
  factors->evaluate =
      Callee{held(std::move(function)), jacobian, vectorized, static_cast<std::size_t>(std::max(1, residual_dim)), factors->types};
  return graph.add(factors, flat, loss);
}

// A graph holds its functions, which may hold the graph: Python's collector has to see them.
int traverse_graph(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  if (!nb::inst_ready(self)) return 0;
  std::map<const FunctionFactors*, std::pair<const FunctionBatch*, long>> own;  // how many batches of this graph share it
  for (const auto& batch : nb::inst_ptr<Graph>(self)->batches())
    if (const auto* functions = dynamic_cast<const FunctionBatch*>(batch.get())) {
      auto& entry = own[functions->function().get()];
      entry.first = functions;
      ++entry.second;
    }
  for (const auto& [function, entry] : own) {
    // There is one Python reference, however many share it: where another graph does, it is not this one's to give.
    if (entry.first->function().use_count() != entry.second) continue;
    if (const Callee* callee = function->evaluate.target<Callee>(); callee != nullptr && callee->function.use_count() == 1)
      Py_VISIT(callee->function->ptr());
  }
  return 0;
}

int clear_graph(PyObject* self) {
  if (nb::inst_ready(self)) *nb::inst_ptr<Graph>(self) = Graph();
  return 0;
}

}  // namespace

std::shared_ptr<nb::object> held(nb::object callable) {
  if (PyCallable_Check(callable.ptr()) == 0)
    throw nb::type_error(("a function is needed, not " + nb::cast<std::string>(nb::repr(callable))).c_str());
  return {new nb::object(std::move(callable)), [](nb::object* object) {
            const nb::gil_scoped_acquire gil;
            delete object;
          }};
}

void note_interrupt(const std::exception& error) {
  const auto* raised = dynamic_cast<const nb::python_error*>(&error);
  if (raised != nullptr && raised->matches(PyExc_KeyboardInterrupt)) was_interrupted = true;
}

void raise_interrupt() {
  if (!was_interrupted.exchange(false)) return;
  PyErr_SetNone(PyExc_KeyboardInterrupt);
  throw nb::python_error();
}

void raise_function_errors(const Graph& graph) {
  std::string text;
  {
    // Asking waits for a function that is being called, which waits for the GIL.
    const nb::gil_scoped_release release;
    for (const auto& batch : graph.batches())
      if (const std::string error = detail::take_error(*batch); !error.empty() && text.empty()) text = batch->name() + ": " + error;
  }
  raise_interrupt();
  if (!text.empty()) throw std::runtime_error(text);
}

PyType_Slot graph_slots[] = {
    {Py_tp_traverse, reinterpret_cast<void*>(traverse_graph)}, {Py_tp_clear, reinterpret_cast<void*>(clear_graph)}, {0, nullptr}};

void bind_functions(nb::class_<Graph>& graph) {
  graph.def("add_function", &add_function, "function"_a, "types"_a, "keys"_a, "residual_dim"_a, "loss"_a = Loss(), "name"_a = "Function",
            "jacobian"_a = false, "vectorized"_a = true,
            R"(Factors whose whitened residual is a Python function, one for each row of `keys`. Returns their ids.

function(which, x0, x1, …) is called for all of them at once: which, an array of n numbers, says for which rows of `keys`; x_k is n × d,
the coordinates of variable k (Point2: x y; Pose2: x y cos sin; Pose3: x y z and the quaternion x y z w). It returns
the residuals, n × residual_dim. With jacobian=True it returns (residuals, J0, J1, …), J_k of n × residual_dim × tangent dimension;
else Jacobians are central differences of 1e-6. With vectorized=False it is called factor by factor, with one number and arrays without
the dimension n: easier to write, and slower.

Works in every back-end and with every loss. The GIL is taken for the call alone. What it raises ends a solve as 'failed', with the
message in Summary.why, and the values stay as they were. Such factors cannot be pickled or saved.)");
}

}  // namespace holdfast::python
