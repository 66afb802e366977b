// Robust losses. One contract for all (conventions, "Robust losses"):
//
//   a term of the cost is  w · ½ ρ(s),  s = ‖r‖² (per block) or s = r_c² summed over the components (per component);
//   ρ(0) = 0, ρ'(0) = 1, ρ' ≥ 0, ρ concave in s; the IRLS weight is ρ'(s).
//
// Thresholds are in sigmas, since r is whitened. Exceptions at 0: StudentT has ρ'(0) = (ν+d)/ν (it is the likelihood of a
// d-dimensional block), and Absolute has ρ'(0) = 1/width, since 2√s itself has no slope there.
//
//   graph.add(factor, keys, Huber{2.0});                      // per block
//   graph.add(factor, keys, per_component(Huber{2.0}));       // each component for itself, as in paper A
//   graph.add(factor, keys, one_sided(Cauchy{1.0}));          // robust only where the measurement is too long (r < 0)
//
// A loss of your own is a plain struct that keeps the contract; it goes wherever the ten below go. A complete one:
//
//   struct Fair {                                             // ρ = 2c² (u − ln(1 + u)), u = √s / c
//     double c;
//     static constexpr bool is_convex = true;
//     Rho rho(double s) const {
//       const double root = std::sqrt(s), u = root / c;
//       return {2 * c * c * (u - std::log1p(u)), 1 / (1 + u), s > 0 ? -0.5 / (c * root * (1 + u) * (1 + u)) : 0};
//     }
//   };
//   graph.add(factor, keys, per_component(Fair{1.4}));
//
// check_loss() (holdfast/testing/loss.hpp) says whether it keeps the contract. Optional members, each unknown to those who do not ask:
//   Rho rho(double s, int d) const;           // in place of rho(s): the same for a block of d components
//   static constexpr bool is_convex = true;   // ½ρ(r²) is a convex function of r; without it it is taken as not convex
//   auto relaxed() const;                     // a convex loss in its place (convex_start); else Huber from where ½ρ(r²) bends down
//   void validate() const;                    // throws BadNumber; called by Graph::add
//   bool operator==(const L&) const;          // else two are the same where their bytes are
//   static const char* name();                // for messages and files; else the C++ type's name
//   double scale() const;                     // its one parameter; with name(), L{} and L{scale}, register_loss<L>() lets files
//                                             // and command lines hold it: "fair:1.4:component"
// GNC needs no member: it widens any loss that is not convex to μ ρ(s/μ) (solvers/gnc.hpp).
#pragma once

#include <cstring>
#include <functional>
#include <holdfast/graph/detail/demangled.hpp>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <typeindex>

namespace holdfast {

/// ρ and its first two derivatives with respect to s.
struct Rho {
  double value;
  double first;
  double second;
};

struct Loss;

namespace detail {

/// A user's loss without its type.
class OwnLoss {
 public:
  virtual ~OwnLoss() = default;
  virtual std::type_index type() const = 0;
  virtual Rho rho(double s, int d) const = 0;
  virtual bool is_convex() const = 0;
  virtual Loss relaxed() const = 0;
  virtual void validate() const = 0;
  virtual bool equals(const OwnLoss& other) const = 0;
  virtual std::string name() const = 0;
  virtual const double* scale() const = 0;  ///< null where it does not say
};

template <class L, class = void>
struct HasRho : std::false_type {};
template <class L>
struct HasRho<L, std::enable_if_t<std::is_same_v<decltype(std::declval<const L&>().rho(1.0)), Rho>>> : std::true_type {};
template <class L, class = void>
struct HasRhoOfBlock : std::false_type {};
template <class L>
struct HasRhoOfBlock<L, std::enable_if_t<std::is_same_v<decltype(std::declval<const L&>().rho(1.0, 1)), Rho>>> : std::true_type {};
template <class L>
using IfOwnLoss = std::enable_if_t<!std::is_base_of_v<Loss, L> && (HasRho<L>::value || HasRhoOfBlock<L>::value)>;

template <class L>
std::shared_ptr<const OwnLoss> make_own_loss(const L& loss);

}  // namespace detail

struct Loss {
  enum class Kind { Squared, Absolute, Huber, PseudoHuber, Cauchy, GemanMcClure, Welsch, Tukey, TruncatedSquares, StudentT, Own };

  Kind kind = Kind::Squared;
  double scale = 1;            ///< the threshold [sigmas]; ν for StudentT; the smoothing width for Absolute; within 1e-100 … 1e100
  bool per_component = false;  ///< each component of the residual is a block of its own
  bool one_sided = false;      ///< squared where r > 0; needs per_component or a residual of one component
  std::shared_ptr<const detail::OwnLoss> own;  ///< of Kind::Own: the user's struct

  Loss() = default;
  Loss(Kind chosen, double threshold) : kind(chosen), scale(threshold) {}
  /// A user's struct.
  template <class L, class = detail::IfOwnLoss<L>>
  Loss(const L& loss) : kind(Kind::Own), own(detail::make_own_loss(loss)) {}

  /// ρ(s) of a block of d components (only StudentT and users' losses ask for d).
  Rho rho(double s, int d = 1) const;
  /// The same for one component r of its own, which may be one-sided.
  Rho rho_of_component(double r) const { return one_sided && r > 0 ? Rho{r * r, 1, 0} : rho(r * r, 1); }

  /// ½ρ(r²) is a convex function of r: one minimum, and Newton steps descend to it.
  bool is_convex() const {
    if (kind == Kind::Own) return own->is_convex();
    return kind == Kind::Squared || kind == Kind::Absolute || kind == Kind::Huber || kind == Kind::PseudoHuber;
  }

  /// The same, or where it is not convex Huber with the same threshold (√ν for StudentT; a user's loss: see above).
  Loss relaxed() const;

  /// Throws BadNumber where the scale breaks its rule, BadOption where one_sided has no single sign to look at.
  void validate(int residual_dim) const;
  std::string str() const;  ///< "huber:2", "cauchy:1:component:one_sided"; what parse reads where is_named()
  /// Reads "huber:2", "squared", "student_t:3:component", "tukey:4.685:one_sided"; throws BadOption listing the names.
  static Loss parse(std::string_view text);
  /// One of the ten, or registered: files may hold it.
  bool is_named() const;

  /// The same but for the threshold: factors whose losses are of one family share a batch.
  bool is_of_family(const Loss& other) const {
    return kind == other.kind && per_component == other.per_component && one_sided == other.one_sided &&
           (kind != Kind::Own || own->type() == other.own->type());
  }
  friend bool operator==(const Loss& a, const Loss& b) {
    return a.is_of_family(b) && (a.kind == Kind::Own ? a.own == b.own || a.own->equals(*b.own) : a.scale == b.scale);
  }
};

/// ρ = s.
struct Squared {
  operator Loss() const { return {}; }
};
/// ρ = 2(√(s + ε²) − ε): |r| without its corner; ε = width [sigmas].
struct Absolute {
  double width = 1e-2;
  operator Loss() const { return {Loss::Kind::Absolute, width}; }
};
/// ρ = s for √s ≤ a, else 2a√s − a².
struct Huber {
  double a = 2;
  operator Loss() const { return {Loss::Kind::Huber, a}; }
};
/// ρ = 2a²(√(1 + s/a²) − 1).
struct PseudoHuber {
  double a = 2;
  operator Loss() const { return {Loss::Kind::PseudoHuber, a}; }
};
/// ρ = c² ln(1 + s/c²).
struct Cauchy {
  double c = 2;
  operator Loss() const { return {Loss::Kind::Cauchy, c}; }
};
/// ρ = c² s / (c² + s).
struct GemanMcClure {
  double c = 2;
  operator Loss() const { return {Loss::Kind::GemanMcClure, c}; }
};
/// ρ = c² (1 − exp(−s/c²)): correntropy (paper B).
struct Welsch {
  double c = 3;
  operator Loss() const { return {Loss::Kind::Welsch, c}; }
};
/// ρ = c²/3 (1 − (1 − s/c²)³) for √s ≤ c, else c²/3.
struct Tukey {
  double c = 4.685;
  operator Loss() const { return {Loss::Kind::Tukey, c}; }
};
/// ρ = min(s, c²).
struct TruncatedSquares {
  double c = 3.5;
  operator Loss() const { return {Loss::Kind::TruncatedSquares, c}; }
};
/// ρ = (ν + d) ln(1 + s/ν): the negative log-likelihood of Student's t with ν degrees of freedom, times two.
struct StudentT {
  double nu = 3;
  operator Loss() const { return {Loss::Kind::StudentT, nu}; }
};

inline Loss per_component(Loss loss) {
  loss.per_component = true;
  return loss;
}
/// For ranges without line of sight, whose measurement is only ever too long: residual (‖·‖ − d)/σ < 0.
inline Loss one_sided(Loss loss) {
  loss.one_sided = true;
  return loss;
}

namespace detail {

template <class L, class = void>
struct IsConvexLoss : std::false_type {};
template <class L>
struct IsConvexLoss<L, std::enable_if_t<L::is_convex>> : std::true_type {};
template <class L, class = void>
struct HasRelaxedLoss : std::false_type {};
template <class L>
struct HasRelaxedLoss<L, std::void_t<decltype(std::declval<const L&>().relaxed())>> : std::true_type {};
template <class L, class = void>
struct ValidatesLoss : std::false_type {};
template <class L>
struct ValidatesLoss<L, std::void_t<decltype(std::declval<const L&>().validate())>> : std::true_type {};
template <class L, class = void>
struct ComparesLoss : std::false_type {};
template <class L>
struct ComparesLoss<L, std::void_t<decltype(std::declval<const L&>() == std::declval<const L&>())>> : std::true_type {};
template <class L, class = void>
struct HasLossName : std::false_type {};
template <class L>
struct HasLossName<L, std::void_t<decltype(L::name())>> : std::true_type {};
template <class L, class = void>
struct HasLossScale : std::false_type {};
template <class L>
struct HasLossScale<L, std::void_t<decltype(std::declval<const L&>().scale())>> : std::true_type {};

/// Huber with the knee where ½ρ(r²) stops being convex (ρ' + 2sρ'' ≤ 0): a user's loss that does not say relaxed().
Loss huber_up_to_bend(const OwnLoss& loss);

template <class L>
class OwnLossOf final : public OwnLoss {
 public:
  explicit OwnLossOf(const L& loss) : loss_(loss) {
    if constexpr (HasLossScale<L>::value) scale_ = loss.scale();
  }
  std::type_index type() const override { return typeid(L); }
  Rho rho(double s, int d) const override {
    if constexpr (HasRhoOfBlock<L>::value)
      return loss_.rho(s, d);
    else
      return (void)d, loss_.rho(s);
  }
  bool is_convex() const override { return IsConvexLoss<L>::value; }
  Loss relaxed() const override {
    if constexpr (HasRelaxedLoss<L>::value) {
      static_assert(!std::is_same_v<std::decay_t<decltype(loss_.relaxed())>, Loss>, "name the type: factors of one loss stay together");
      return Loss(loss_.relaxed());
    } else {
      return huber_up_to_bend(*this);
    }
  }
  void validate() const override {
    if constexpr (ValidatesLoss<L>::value) loss_.validate();
  }
  bool equals(const OwnLoss& other) const override {
    const L& theirs = static_cast<const OwnLossOf&>(other).loss_;
    if constexpr (ComparesLoss<L>::value)
      return loss_ == theirs;
    else if constexpr (std::is_trivially_copyable_v<L>)
      return std::memcmp(static_cast<const void*>(&loss_), static_cast<const void*>(&theirs), sizeof(L)) == 0;
    else
      return (void)theirs, false;
  }
  std::string name() const override {
    if constexpr (HasLossName<L>::value)
      return L::name();
    else
      return demangled(typeid(L));
  }
  const double* scale() const override { return HasLossScale<L>::value ? &scale_ : nullptr; }

 private:
  L loss_;
  double scale_ = 0;
};

template <class L>
std::shared_ptr<const OwnLoss> make_own_loss(const L& loss) {
  return std::make_shared<const OwnLossOf<L>>(loss);
}

/// make(scale): the loss with this scale, or with its own default where it is null.
void register_loss(std::string name, std::type_index type, std::function<Loss(const double* scale)> make);

}  // namespace detail

/// From here on Loss::parse knows L by its name, and files may hold it. Throws BadOption where the name is taken or no single word.
template <class L>
void register_loss() {
  static_assert(detail::HasLossName<L>::value && detail::HasLossScale<L>::value, "a named loss says name() and scale()");
  detail::register_loss(L::name(), typeid(L), [](const double* scale) { return Loss(scale != nullptr ? L{*scale} : L{}); });
}

}  // namespace holdfast
