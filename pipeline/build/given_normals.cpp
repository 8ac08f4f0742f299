#include "pipeline/build/given_normals.h"

#include "pipeline/build/own_points.h"
#include "slim/normals/estimate.h"
#include "slim/normals/patch_signs.h"
#include "slim/normals/repair.h"
#include "slim/normals/scan_signs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slim {
namespace {

// beyond this share a cloud's own normals are not to be trusted
constexpr double kManyContrary = 0.1;
// points that say whether given normals are those of a surface, and which side is in
constexpr double kEvidenceSamples = 2000;

void turn(const std::vector<bool>& which, PointBlock& points) {
    for (std::size_t i = 0; i < which.size(); ++i)
        if (which[i]) points.normal[i] = -points.normal[i];
}

/// Of each scan whose sensor is known, samples that face it less the others.
std::vector<std::int64_t> facing_of(const PointBlock& points,
                                    const std::vector<std::uint32_t>& samples,
                                    const std::vector<Vec3d>& sensors) {
    std::vector<std::int64_t> facing(sensors.size(), 0);
    for (const std::uint32_t i : samples) {
        const std::size_t scan = points.has_scans() ? points.scan[i] : 0;
        if (scan >= sensors.size() || !is_finite(sensors[scan])) continue;
        const bool faces =
            dot(to_double(points.normal[i]), sensors[scan] - points.position[i]) > 0;
        facing[scan] += faces ? 1 : -1;
    }
    return facing;
}

/// Whether most of the samples face their sensors, so that a surface may well enclose them. False
/// where no sensor is known.
bool faces_sensors(const PointBlock& points, const std::vector<std::uint32_t>& samples,
                   const std::vector<Vec3d>& sensors) {
    const auto facing = facing_of(points, samples, sensors);
    return std::accumulate(facing.begin(), facing.end(), std::int64_t{0}) > 0;
}

/// Turns scans whose normals are turned round against the others', by their sensors or as the
/// fewer, of a job of one slice: which are in the minority is not known of less. Returns how many
/// points these have.
std::size_t turn_contrary_scans(PointBlock& points, const NearestSearch& search,
                                const std::vector<std::uint32_t>& samples,
                                const std::vector<Vec3d>& sensors) {
    const std::vector<bool> contrary =
        contrary_scans(points, search, samples, facing_of(points, samples, sensors));
    if (std::find(contrary.begin(), contrary.end(), true) == contrary.end()) return 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (contrary[points.scan[i]]) points.normal[i] = -points.normal[i], ++n;
    return n;
}

/// Some 2,000 of the slice's own points, or all.
std::vector<std::uint32_t> evidence_samples(const PointBlock& points,
                                            const std::vector<bool>& own) {
    const auto n = static_cast<double>(std::count(own.begin(), own.end(), true));
    return sample_points(points, own, kEvidenceSamples / n);
}

/// Mends normals here and there, and in patches where their seams show; which side of these has
/// fewer points is only known of a whole cloud.
NormalAudit mend(PointBlock& points, const NearestSearch& search, const std::vector<bool>& own,
                 bool turns_patches, NormalsReport& report) {
    NormalAudit audit = repair_contrary_normals(points, search.boxes(), own);
    if (audit.has_seams() && !audit.has_mixed_signs()) {
        const ContraryPatches patches = contrary_patches(points, search);
        report.of_contrary_patches = count_own(own, patches.is_contrary);
        if (turns_patches && patches.n > 0) {
            turn(patches.is_contrary, points);
            report.turned = audit.contrary;
            audit = repair_contrary_normals(points, search.boxes(), own);
        }
    }
    return audit;
}

/// Where signs are random no neighbours agree, so that there is no majority to oppose.
std::string contrary_text(double share, double opposed) {
    if (share <= kManyContrary)
        return fmt::format("{:.0f} % of neighbouring normals oppose each other", 100 * opposed);
    return fmt::format("{:.0f} % of the normals oppose a majority of their neighbours, {:.0f} % of "
                       "neighbouring normals each other",
                       100 * share, 100 * opposed);
}

std::string contrary_patches_text(std::size_t n, std::size_t n_own, bool are_turned) {
    const std::string text = fmt::format(
        "{} points, {:.1f} %, lie in patches whose normals are turned round against those about "
        "them: ",
        n, 100 * static_cast<double>(n) / static_cast<double>(n_own));
    if (are_turned) return text + "turned";
    return text + "which are right is not known of a slice, they are kept. Build in one slice, or "
                  "with --normals estimate";
}

}  // namespace

Mistrust audit_given(PointBlock& points, const NearestSearch& search, const std::vector<bool>& own,
                     std::size_t n_own, const std::vector<Vec3d>& sensors, bool is_whole,
                     NormalsReport& report, Reporter& reporter) {
    if (is_whole)
        report.of_contrary_scans =
            turn_contrary_scans(points, search, evidence_samples(points, own), sensors);
    if (report.of_contrary_scans > 0)
        reporter.warn(fmt::format(
            "{} points are of scans whose normals are turned round against the others': turned",
            report.of_contrary_scans));
    const NormalAudit audit = mend(points, search, own, is_whole, report);
    if (report.of_contrary_patches > 0)
        reporter.warn(contrary_patches_text(report.of_contrary_patches, n_own, is_whole));
    report.turned += audit.contrary;
    report.noisy = audit.noisy;
    const double share = static_cast<double>(audit.contrary) / static_cast<double>(n_own);
    if (share > kManyContrary || audit.has_mixed_signs())
        return {contrary_text(share, audit.opposed / std::max(audit.compared, 1.0)), true};
    const std::vector<std::uint32_t> samples = evidence_samples(points, own);
    report.evidence = evidence_of(points, search, samples);
    if (report.evidence.is_off_surface())
        if (const std::size_t k = neighbors_beyond_strips(search, samples, kUsualNeighbors);
            k > kUsualNeighbors)
            report.evidence = evidence_of(points, search, samples, k);
    report.evidence.stand_for(n_own);
    if (report.evidence.is_off_surface())
        return {
            fmt::format("{:.0f} % of the normals stand more than 45 degrees off the surface that "
                        "the points make",
                        100 * static_cast<double>(report.evidence.n_off) /
                            static_cast<double>(report.evidence.n_flat))};
    if (faces_sensors(points, samples, sensors)) report.evidence = {};
    return {};
}

}  // namespace slim
