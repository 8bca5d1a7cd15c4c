// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_audit/audit.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <memory>
#include <thread>

#include "experiments.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/physics.hpp"
#include "replay.hpp"

namespace sim2sim {
namespace {

/// [-] Ratio of a mass or force to the reference's; none unless both worlds have one.
std::optional<double> ratioOf(Property property, const Measurements& reference, const Measurements& world) {
  const auto& of_reference = reference[property].value;
  const auto& of_world = world[property].value;
  if (!describe(property).mass_like || !of_reference || !of_world) {
    return std::nullopt;
  }
  const double ratio = *of_world / *of_reference;
  return std::isfinite(ratio) && ratio > 0.0 ? std::optional(ratio) : std::nullopt;
}

/// Common factor of all masses and forces of `world` against the reference: no motion depends on it, so it is taken to
/// be the one that leaves most of them the same, and of several such the one that leaves the tee's mass the same.
double commonFactor(const Measurements& reference, const Measurements& world) {
  std::vector<Property> properties = {Property::kTeeMass};  // first, so that it wins where others are no better
  for (const PropertyDescription& description : allProperties()) {
    properties.push_back(description.property);
  }
  double best = 1.0;
  int most = 0;
  for (const Property candidate : properties) {
    const std::optional<double> factor = ratioOf(candidate, reference, world);
    if (!factor) {
      continue;
    }
    const auto same = std::count_if(properties.begin() + 1, properties.end(), [&](Property property) {
      const std::optional<double> ratio = ratioOf(property, reference, world);
      return ratio && std::abs(*ratio / *factor - 1.0) <= describe(property).resolution.relative;
    });
    if (same > most) {
      most = static_cast<int>(same);
      best = *factor;
    }
  }
  return best;
}

/// Measurements with masses and forces in SI: the reference's gain, their unit, is taken to be this one [N s/m].
Measurements inSi(const Measurements& measured, double common_factor, double gain) {
  Measurements result = measured;
  for (const PropertyDescription& description : allProperties()) {
    if (const auto& value = measured[description.property].value; value && description.mass_like) {
      const double factor = gain / common_factor;
      result.set(description.property, *value * factor, measured[description.property].uncertainty * factor);
    }
  }
  return result;
}

/// Measurements of `world` in units in which they can be compared with the reference's, which are in SI.
Measurements comparable(const Measurements& reference, const Measurements& world, const pusht::Physics& task) {
  // Where actions are positions, the unit is the task's mass of the tee.
  const double factor = task.drive == pusht::Drive::kVelocity ? commonFactor(reference, world) : 1.0;
  return inSi(world, factor, task.servo_gain);
}

/// Mass [kg] that the pusher has if its servo is explicit. It acts then at the velocity at a substep's begin, and moves
/// a free pusher as an implicit one moves a pusher with less mass; no free motion tells.
std::optional<double> massOfExplicit(const Measurements& in_si) {
  const auto& mass = in_si[Property::kPusherMass].value;
  const auto& lag = in_si[Property::kServoLag].value;
  const auto& gain = in_si[Property::kServoGain].value;
  return mass && lag && gain && std::isfinite(*gain) ? std::optional(*mass + *lag * *gain) : std::nullopt;
}

/// Whether the servo of `world` is read as explicit: that gives the pusher the mass of the `other` world's, and as an
/// implicit one's the mass is neither that nor the task's.
bool isServoExplicit(const Measurements& world, const Measurements& other) {
  const std::optional<double> of_explicit = massOfExplicit(world);
  const auto& of_other = other[Property::kPusherMass].value;
  const auto is_same = [](double a, double b) {
    return std::abs(a - b) <= describe(Property::kPusherMass).resolution.relative * std::abs(b);
  };
  const double mass = world[Property::kPusherMass].value.value_or(0.0);
  return of_explicit && of_other && is_same(*of_explicit, *of_other) && !is_same(mass, *of_other) &&
         !is_same(mass, pusht::Physics().pusher_mass);
}

/// Sets mass and lag by the reading of the servo.
void readServo(Measurements& in_si, bool is_explicit) {
  if (is_explicit) {
    in_si.set(Property::kPusherMass, *massOfExplicit(in_si));
  } else if (in_si[Property::kServoLag].value) {
    in_si.set(Property::kServoLag, 0.0);
  }
}

/// Reads the servos of both worlds, whose masses are in SI.
void readServos(Measurements& reference, Measurements& world) {
  const bool is_world_explicit = isServoExplicit(world, reference);
  const bool is_reference_explicit = !is_world_explicit && isServoExplicit(reference, world);
  readServo(world, is_world_explicit);
  readServo(reference, is_reference_explicit);
}

double distance(double a, double b) { return a == b ? 0.0 : std::abs(a - b); }  // infinities may be equal

/// Properties that are held against the start tolerance.
bool isOfStart(Property property) {
  return property >= Property::kStartPusherPosition && property <= Property::kFixedPoint;
}

/// Sets how much may differ, and what that is.
void allow(Comparison& comparison, double amount, const char* what) {
  if (amount > comparison.allowed || comparison.held_against.empty()) {
    comparison.allowed = std::max(amount, comparison.allowed);
    comparison.held_against = what;
  }
}

void setAllowed(Comparison& comparison, const Measurement& reference, const Measurement& engine,
                const std::vector<Measurements>& variants, double start_tolerance) {
  const Property property = comparison.property;
  const Resolution& resolution = describe(property).resolution;
  allow(comparison, std::max(resolution.absolute, resolution.relative * std::abs(*reference.value)), "resolution");
  if (isOfStart(property)) {
    allow(comparison, start_tolerance, "start tolerance");
  }
  allow(comparison, reference.uncertainty + engine.uncertainty, "fit");
  for (const Measurements& variant : variants) {
    if (const auto& value = variant[property].value) {
      const double spread = distance(*value, *reference.value);
      allow(comparison, std::isfinite(spread) ? spread : 0.0, "model variants");
    }
  }
}

double effectOf(const Comparison& comparison) {
  const PropertyDescription& description = describe(comparison.property);
  const double difference = distance(*comparison.engine, *comparison.reference);
  if (!description.mass_like) {
    constexpr double kNoWall = 0.01;  // [m] beyond a wall that the tee of a world without it may get in a short replay
    return description.effect * (std::isfinite(difference) ? difference : kNoWall);
  }
  if (!std::isfinite(difference)) {
    return description.effect;  // a limit that one world does not have
  }
  const double larger = std::max(std::abs(*comparison.engine), std::abs(*comparison.reference));
  return larger > 0.0 ? description.effect * difference / larger : 0.0;
}

Comparison compareOne(Property property, const Measurements& reference, const Measurements& engine,
                      const std::vector<Measurements>& variants, double start_tolerance) {
  const Measurement& of_reference = reference[property];
  const Measurement& of_engine = engine[property];
  Comparison comparison = {property, PropertyVerdict::kCannotTell, of_reference.value, of_engine.value};
  if (!of_reference.value || !of_engine.value) {
    comparison.reason = !of_engine.value ? of_engine.problem : "in the reference: " + of_reference.problem;
    return comparison;
  }
  setAllowed(comparison, of_reference, of_engine, variants, start_tolerance);
  const bool same = distance(*comparison.engine, *comparison.reference) <= comparison.allowed;
  comparison.verdict = same ? PropertyVerdict::kSame : PropertyVerdict::kDiffers;
  return comparison;
}

/// [-] Size of a difference, in multiples of what counts; at most that of a thing which one of the worlds does not
/// have.
double sizeOf(const Comparison& comparison) {
  constexpr double kAbsent = 100.0;
  const double felt = describe(comparison.property).resolution.felt;
  const double size = distance(*comparison.engine, *comparison.reference) / (felt > 0.0 ? felt : comparison.allowed);
  return size < kAbsent ? size : kAbsent;
}

/// Whether `cause` is large enough for `effect` to be what it shows there. Of the planted faults, one of size 1 moves
/// no other property by more than this reach.
bool mayFollow(const Comparison& effect, const Comparison& cause) {
  constexpr double kReach = 4.0;
  return cause.verdict == PropertyVerdict::kDiffers && sizeOf(effect) <= kReach * sizeOf(cause);
}

/// Cause in `comparisons` from which a difference may follow, the largest; none if there is none.
const Comparison* causeIn(const std::vector<Comparison>& comparisons, const Comparison& difference) {
  const Comparison* largest = nullptr;
  for (const Property property : describe(difference.property).follows_from) {
    const Comparison& cause = comparisons[static_cast<std::size_t>(property)];
    if (mayFollow(difference, cause) && (largest == nullptr || sizeOf(cause) > sizeOf(*largest))) {
      largest = &cause;
    }
  }
  return largest;
}

/// Takes differences back that follow from others, and names the one from which all of them follow.
void explainAway(std::vector<Comparison>& comparisons) {
  const std::vector<Comparison> before = comparisons;
  for (Comparison& comparison : comparisons) {
    const Comparison* cause = comparison.verdict == PropertyVerdict::kDiffers ? causeIn(before, comparison) : nullptr;
    if (cause == nullptr) {
      continue;
    }
    for (const Comparison* earlier = cause; earlier != nullptr; earlier = causeIn(before, *earlier)) {
      cause = earlier;
    }
    comparison.verdict = PropertyVerdict::kCannotTell;
    comparison.reason = std::string("may follow from ") + describe(cause->property).title;
  }
}

void requireKeys(const std::vector<std::string>& departures) {
  const auto& known = allProperties();
  for (const std::string& key : departures) {
    if (std::none_of(known.begin(), known.end(), [&](const PropertyDescription& one) { return one.key == key; })) {
      throw pusht::InvalidInput("departure '" + key + "' of a kind: must be the key of a property of an audit");
    }
  }
}

/// World with what was measured in it.
struct Subject {
  Subject(const AuditedWorld& audited, std::uint64_t seed) : world(audited.make()), bench(*world, audited.make, seed) {}

  std::unique_ptr<pusht::Simulator> world;
  Bench bench;
  Measurements measurements{};
};

/// Measures each of `subjects` in one thread. measure() throws nothing that a world throws.
void measureAll(std::vector<Subject>& subjects, int threads) {
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < subjects.size(); i = next++) {
      subjects[i].measurements = measure(subjects[i].bench);
    }
  };
  std::vector<std::thread> others;
  for (int i = 1; i < threads; ++i) {
    others.emplace_back(work);
  }
  work();
  for (std::thread& other : others) {
    other.join();
  }
}

/// [m] Divergence of a policy's replays; none if a world fails in them.
std::optional<double> divergenceIn(pusht::Simulator& engine, pusht::Simulator& reference, pusht::Policy& policy,
                                   std::uint64_t seed) {
  try {
    return divergenceInReplays(engine, recordEpisodes(reference, policy, seed));
  } catch (const pusht::RuntimeFault&) {
    return std::nullopt;
  }
}

}  // namespace

const char* nameOf(PropertyVerdict verdict) {
  switch (verdict) {
    case PropertyVerdict::kSame:
      return "same";
    case PropertyVerdict::kDiffers:
      return "differs";
    case PropertyVerdict::kCannotTell:
      return "cannot tell";
  }
  return "";
}

std::vector<Comparison> Audit::findings() const {
  std::vector<Comparison> result;
  std::copy_if(comparisons.begin(), comparisons.end(), std::back_inserter(result),
               [](const Comparison& comparison) { return comparison.verdict == PropertyVerdict::kDiffers; });
  std::stable_sort(result.begin(), result.end(), [](const Comparison& a, const Comparison& b) {
    return a.isContractError() != b.isContractError() ? a.isContractError() : a.effect > b.effect;
  });
  return result;
}

bool Audit::hasContractErrors() const {
  return std::any_of(comparisons.begin(), comparisons.end(),
                     [](const Comparison& comparison) { return comparison.isContractError(); });
}

Audit compare(const Measurements& reference, const Measurements& engine, const std::vector<Measurements>& variants,
              double start_tolerance, const std::vector<std::string>& departures, const pusht::Task& task) {
  requireKeys(departures);
  Measurements reference_si = inSi(reference, 1.0, task.physics.servo_gain);
  Measurements engine_si = comparable(reference, engine, task.physics);
  readServos(reference_si, engine_si);
  std::vector<Measurements> variants_si;
  variants_si.reserve(variants.size());
  for (const Measurements& variant : variants) {
    variants_si.push_back(comparable(reference, variant, task.physics));
    readServo(variants_si.back(), isServoExplicit(variants_si.back(), reference_si));
    // A variant's explicit servo, as of MuJoCo's Euler, makes no other explicit servo the same.
    variants_si.back().withdraw(Property::kServoLag, "of a model variant");
  }
  Audit result;
  for (const PropertyDescription& description : allProperties()) {
    result.comparisons.push_back(
        compareOne(description.property, reference_si, engine_si, variants_si, start_tolerance));
  }
  explainAway(result.comparisons);
  for (Comparison& comparison : result.comparisons) {
    comparison.effect = comparison.verdict == PropertyVerdict::kDiffers ? effectOf(comparison) : 0.0;
    comparison.is_declared = std::count(departures.begin(), departures.end(), describe(comparison.property).key) > 0;
  }
  return result;
}

Audit audit(const AuditedWorld& reference, const AuditedWorld& engine, const std::vector<AuditedWorld>& variants,
            std::uint64_t seed, int threads, pusht::Policy* policy) {
  std::vector<Subject> subjects;
  subjects.emplace_back(reference, seed);
  subjects.emplace_back(engine, seed);
  for (const AuditedWorld& variant : variants) {
    subjects.emplace_back(variant, seed);
  }
  measureAll(subjects, threads);
  std::vector<Measurements> of_variants;
  for (std::size_t i = 2; i < subjects.size(); ++i) {
    of_variants.push_back(subjects[i].measurements);
  }
  std::vector<std::string> departures = reference.departures;
  departures.insert(departures.end(), engine.departures.begin(), engine.departures.end());
  Audit result = compare(subjects[0].measurements, subjects[1].measurements, of_variants,
                         std::max(subjects[0].world->startTolerance(), subjects[1].world->startTolerance()), departures,
                         subjects[0].world->task());
  result.reference = reference.title;
  result.engine = engine.title;
  for (const AuditedWorld& variant : variants) {
    result.variants.push_back(variant.title);
  }
  result.seed = seed;
  if (policy != nullptr) {
    result.divergence = divergenceIn(*subjects[1].world, *subjects[0].world, *policy, seed);
  }
  return result;
}

}  // namespace sim2sim
