#include "pipeline/build/slice_normals.h"

#include "pipeline/build/given_normals.h"
#include "pipeline/build/normals_rims.h"
#include "pipeline/build/own_points.h"
#include "slim/base/hash.h"
#include "slim/base/parallel.h"
#include "slim/fit/noise_variance.h"
#include "slim/normals/estimate.h"
#include "slim/normals/repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <utility>

namespace slim {
namespace {

constexpr std::uint64_t kSample = 0x6c616d;  // purpose of the hash
constexpr std::size_t kGrain = 16384;        // points a task
// points of which noise and spacing are measured before normals are estimated
constexpr double kFewSamples = 4000;
constexpr std::size_t kFew = 100;  // one in so many, or less, is not worth it
// Neighbours for an estimate, at most: the radius of their ball, sqrt(k / pi) spacings, is 1.4
// times the noise or more (slim/normals/notes/0002).
constexpr std::size_t kMostNeighbors = 64;
// Noise in spacings from which on more are taken where those show no plane: 16 reach 2.3 spacings.
constexpr double kThick = 0.5;

// of squares of lengths that floats hold to the last bit
constexpr float kLeastSquare = 1e-30f, kMostSquare = 1e30f;

/// Whatever the file's unit of normals: their squares may be beyond floats.
Vec3f unit_normal(const Vec3f& n) {
    const float sq = sq_length(n);
    if (sq > kLeastSquare && sq < kMostSquare) return normalized(n);
    return is_finite(n) ? to_float(normalized(to_double(n))) : Vec3f{};
}

/// Makes normals that are not finite zero, the others unit vectors. Returns how many are zero.
std::size_t normalize_all(std::vector<Vec3f>& normals) {
    std::atomic<std::size_t> n_missing = 0;
    parallel_blocks(normals.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::size_t missing = 0;
        for (std::size_t i = begin; i < end; ++i) {
            Vec3f& n = normals[i];
            n = unit_normal(n);
            missing += !(sq_length(n) > 0);
        }
        n_missing += missing;
    });
    return n_missing;
}

std::vector<std::uint32_t> points_without_normal(const PointBlock& points) {
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i < points.size(); ++i)
        if (!(sq_length(points.normal[i]) > 0)) out.push_back(i);
    return out;
}

/// What normals are estimated from.
struct EstimateRules {
    std::size_t neighbors = kUsualNeighbors;
    NoiseOfPoints noise = NoiseOfPoints::thin;
};

/// Neighbours enough for a ball of 1.4 times the typical noise; the usual ones where hardly any are
/// to be estimated.
EstimateRules rules_for_noise(const PointBlock& points, const NearestSearch& search,
                              const std::vector<bool>& own, std::size_t n_wanted) {
    if (kFew * n_wanted < points.size()) return {};
    const double n_own = static_cast<double>(std::count(own.begin(), own.end(), true));
    const std::vector<std::uint32_t> samples = sample_points(points, own, kFewSamples / n_own);
    const std::size_t fewest = neighbors_beyond_strips(search, samples, kUsualNeighbors);
    if (fewest > kUsualNeighbors) return {fewest};
    const NoiseVariance noise = estimate_noise_variance(search, samples, 0);
    if (!(noise.spacing > 0)) return {};
    const double sq_share = noise.typical / (noise.spacing * noise.spacing);
    const double k = std::ceil(2 * std::numbers::pi * sq_share);
    return {static_cast<std::size_t>(
                std::clamp(k, double{kUsualNeighbors}, double{kMostNeighbors})),
            sq_share > kThick * kThick ? NoiseOfPoints::thick : NoiseOfPoints::thin};
}

/// Estimates and orients the normals of `wanted`; the signs of the others are taken as known.
void estimate_missing(PointBlock& points, const NearestSearch& search, const std::vector<bool>& own,
                      const std::vector<std::uint32_t>& wanted,
                      const std::optional<WholeScene>& whole, const std::vector<Vec3d>& sensors,
                      const std::vector<Vec3f>& hints, int neighbors, bool seen_from_above,
                      NormalsReport& report) {
    const EstimateRules rules = neighbors > 0
                                    ? EstimateRules{static_cast<std::size_t>(neighbors)}
                                    : rules_for_noise(points, search, own, wanted.size());
    report.neighbors = rules.neighbors;
    NeighborGraph graph = estimate_normals(points, search, wanted, rules.neighbors,
                                           report.degenerate, own, rules.noise);
    report.on_lines = graph.n_on_lines;
    report.estimates_widened = graph.n_widened;
    report.estimated = count_own(own, wanted);
    std::vector<bool> known(points.size(), true);
    for (const std::uint32_t i : wanted) {
        const std::size_t scan = points.has_scans() ? points.scan[i] : 0;
        known[i] = scan < sensors.size() && is_finite(sensors[scan]);
    }
    if (orient_to_sensors(points, wanted, sensors) < wanted.size())
        report.orientation = orient_by_neighbors(points, std::move(graph), known, whole, hints,
                                                 own, seen_from_above);
    report.orientation.by_sensor =
        report.estimated - report.orientation.by_neighbors - report.orientation.by_rule;
}

/// Estimates are wrong here and there, too: the sensor's word at a grazing angle, a vote at a
/// crease. How many are is what the fit takes for the noise of normals.
void audit_estimates(PointBlock& points, const NearestSearch& search, const std::vector<bool>& own,
                     const std::vector<std::uint32_t>& wanted, NormalsReport& report) {
    std::vector<bool> estimated(points.size(), false);
    for (const std::uint32_t i : wanted) estimated[i] = true;
    const NormalAudit audit = repair_contrary_normals(points, search.boxes(), own, estimated);
    report.estimates_turned = audit.contrary;
    report.noisy += audit.noisy;
}

/// What became of a cloud whose normals are not to be trusted.
std::string estimated_anew(const OrientReport& orientation, bool they_hint) {
    std::string text = ": all normals are estimated anew";
    if (!they_hint || orientation.by_rule == 0) return text;
    if (orientation.by_hints > 0) text += ", on the side that most of the given ones are on";
    if (orientation.by_hints < orientation.by_rule)
        text += ", as --normals estimate has it: the given ones leave in doubt which side is out";
    return text;
}

/// --normals flip: the other side is out. What the slices before have is flipped, and known here,
/// where signs carry over.
void flip_all(std::vector<Vec3f>& normals) {
    for (Vec3f& n : normals) n = -n;
}

}  // namespace

std::vector<std::uint32_t> sample_points(const PointBlock& points, const std::vector<bool>& own,
                                         double share) {
    using Chosen = std::vector<std::pair<std::uint64_t, std::uint32_t>>;
    std::vector<Chosen> parts((points.size() + kGrain - 1) / kGrain);
    parallel_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        // Lanes look at points by the number that unit_interval() makes a share of.
        const auto limit = static_cast<std::uint64_t>(std::ceil(std::min(share, 1.0) * 0x1p53));
        std::array<std::uint64_t, 64> hashes;
        for (std::size_t first = begin; first < end; first += hashes.size()) {
            const std::size_t n = std::min(hashes.size(), end - first);
            std::uint64_t n_chosen = 0;
            for (std::size_t k = 0; k < n; ++k) {
                hashes[k] = keyed_hash(0, points.id[first + k], kSample);
                n_chosen += hashes[k] >> 11 < limit ? 1 : 0;
            }
            for (std::size_t k = 0; n_chosen > 0 && k < n; ++k)
                if (hashes[k] >> 11 < limit && own[first + k])
                    parts[begin / kGrain].emplace_back(hashes[k],
                                                       static_cast<std::uint32_t>(first + k));
        }
    });
    Chosen chosen;
    for (const Chosen& part : parts) chosen.insert(chosen.end(), part.begin(), part.end());
    std::sort(chosen.begin(), chosen.end());
    std::vector<std::uint32_t> samples;
    for (const auto& [hash, i] : chosen) samples.push_back(i);
    return samples;
}

OrientReport orient_sample(PointBlock& points, const NormalsConfig& config,
                           const std::vector<Vec3d>& sensors) {
    const NearestSearch search(points.position);
    points.normal.assign(points.size(), Vec3f{});
    const std::vector<std::uint32_t> wanted = points_without_normal(points);
    const std::vector<bool> own(points.size(), true);
    NormalsReport report;
    estimate_missing(points, search, own, wanted, std::nullopt, sensors, {}, config.neighbors,
                     false, report);
    audit_estimates(points, search, own, wanted, report);
    return report.orientation;
}

NormalsReport give_normals(PointBlock& points, const NearestSearch& search,
                           const std::vector<bool>& own,
                           const std::optional<WholeScene>& whole,
                           const NormalsConfig& config, const SlicePlan& plan,
                           const std::vector<Vec3d>& sensors, bool seen_from_above,
                           Reporter& reporter) {
    NormalsReport report;
    std::vector<std::uint32_t> wanted;
    const bool flips = config.normals == "flip", carries = signs_carry_over(config, plan);
    if (flips && carries) flip_all(points.normal);
    if (normalize_all(points.normal) > 0) wanted = points_without_normal(points);
    const std::size_t n_points = static_cast<std::size_t>(std::count(own.begin(), own.end(), true));
    if (config.normals == "keep" && count_own(own, wanted) > 0)
        reporter.warn(fmt::format(
            "{} points have no normal and none is estimated (--normals keep): they are estimated "
            "with --normals auto",
            count_own(own, wanted)));
    const std::size_t n_own = n_points - count_own(own, wanted);
    if (config.normals == "keep") {
        report.kept = n_own;
        return report;
    }
    std::vector<Vec3f> hints;
    std::string mistrusted;
    if (n_own > 0 && !carries) {
        const Mistrust mistrust =
            audit_given(points, search, own, n_own, sensors, plan.slices.size() == 1, report,
                        reporter);
        mistrusted = mistrust.why;
        if (!mistrust.why.empty()) {
            report.evidence = {};
            report.turned = report.noisy = report.of_contrary_patches = 0;
            if (mistrust.they_hint) hints = std::move(points.normal);
            points.normal.assign(points.size(), Vec3f{});
            wanted = points_without_normal(points);
        }
    }
    if (!carries)  // else all are estimated but those of the rim
        report.kept = n_points - std::min(n_points, count_own(own, wanted) + report.turned +
                                                        report.of_contrary_patches);
    if (!wanted.empty()) {
        estimate_missing(points, search, own, wanted, whole, sensors, hints, config.neighbors,
                         seen_from_above, report);
        audit_estimates(points, search, own, wanted, report);
        if (kFew * report.on_lines > report.estimated)
            reporter.warn(fmt::format(
                "{} points lie on lines, of wires or a scan, too far from each other for "
                "normals that say anything: expected scan lines at most some 100 "
                "points' spacing apart (20 where most of the cloud is dense both "
                "ways), or normals in the input",
                report.on_lines));
    }
    if (!mistrusted.empty())
        reporter.warn(mistrusted + estimated_anew(report.orientation, !hints.empty()));
    if (flips) flip_all(points.normal);
    if (flips) report.evidence.flip();
    return report;
}

}  // namespace slim
