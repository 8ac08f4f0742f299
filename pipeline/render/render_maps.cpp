#include "pipeline/render/render_maps.h"

#include "pipeline/render/render_asked.h"
#include "raytrace/camera.h"
#include "slim/base/error.h"
#include "slim/base/nearest_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <string_view>

namespace slim {
namespace {

constexpr const char* kMinus = "\u2212";

const std::map<std::string, MapSpec>& specs() {
    static const std::string concave = std::string("concave ") + kMinus;
    static const std::string hyperbolic = std::string("saddle ") + kMinus;
    static const std::string inside = std::string("inside ") + kMinus;
    static const std::map<std::string, MapSpec> table{
        {"mean", {"mean curvature", -1, true, "convex +", concave.c_str()}},
        {"gauss", {"Gauss curvature", -2, true, "cap or cup +", hyperbolic.c_str()}},
        {"k1", {"curvature k1", -1, true, "convex +", concave.c_str()}},
        {"k2", {"curvature k2", -1, true, "convex +", concave.c_str()}},
        {"e1", {"|e1| = |dk1/dt1|", -2, false, "sign goes with t1", ""}},
        {"e2", {"|e2| = |dk2/dt2|", -2, false, "sign goes with t2", ""}},
        {"dk1_dt2", {"|dk1/dt2|", -2, false, "sign goes with t2", ""}},
        {"dk2_dt1", {"|dk2/dt1|", -2, false, "sign goes with t1", ""}},
        {"truth_distance", {"distance to truth", 1, true, "outside +", inside.c_str()}},
        {"depth", {"depth", 1, false, "far", "near"}},
        {"error", {"fit error (RMS)", 1, false, "", ""}},
        {"coverage", {"sum of weights", 0, false, "", ""}},
    };
    return table;
}

std::string unit_text(const std::string& unit, int power) {
    const std::string u = unit.empty() ? "model unit" : unit;
    if (power == 0) return "";
    if (power == 1) return unit.empty() ? "model units" : unit;
    return "1/" + u + (power == -2 ? "\u00b2" : "");
}

double curvature_of_radius(double diagonals, int length_power, double diagonal) {
    return std::pow(1 / (diagonals * diagonal), -length_power);
}

/// What the fit makes of flat faces, which would look like a storm: a radius of 2 diagonals at
/// least, so that noise does not leave bent surfaces pale, and 40 at most.
constexpr double kMostOfFit = 0.5, kLeastOfFit = 0.025;

/// All is flat that is bent less: single leaves whose balls reach past an edge of exact faces that
/// none of their sheets is for have residuals of 1.6e-4 L, where the middle one's is 1.6e-7 L, and
/// bend to radii of 47 diagonals (twelve_original: k1 0.021, mean curvature 0.010 at most, at 95 of
/// 100 pixels 0.0025 and 0.0012). By their own residuals they know no curvature below 0.18.
constexpr double kFlat = 0.0125;

double flat_curvature(const MapScale& scale) {
    return std::clamp(scale.curvature_noise, kLeastOfFit / scale.diagonal,
                      kMostOfFit / scale.diagonal);
}

/// Below it a range shows rounding, the last digits of floats, derivatives of curvatures whose
/// radii are 100 diagonals; or, of curvatures, what the fit makes of flat faces.
double least_range(const std::string& aov, int length_power, const MapScale& scale) {
    const double l = scale.diagonal > 0 ? scale.diagonal : 1;
    if (length_power > 0) return 1e-7 * l;
    if (length_power == 0) return 1e-7;
    if (is_curvature(aov) && scale.diagonal > 0)
        return std::pow(flat_curvature(scale), -length_power);
    return curvature_of_radius(100, length_power, l);
}

/// Curvatures and their derivatives up to it are those of flat faces: radii of 10 diagonals and
/// more, of curvatures no more than the fit makes of such. (Of scans a few in 100 pixels, of parts
/// most: percentile_of_abs.)
double flat_until(const std::string& aov, int length_power, const MapScale& scale) {
    if (!(length_power < 0 && scale.diagonal > 0)) return 0;
    const double flat = curvature_of_radius(10, length_power, scale.diagonal);
    return is_curvature(aov) ? std::min(flat, std::pow(flat_curvature(scale), -length_power))
                             : flat;
}

/// Whether a curvature that most of a picture does not exceed is one of flat faces: it has none to
/// show, be its leaves ever so exact.
bool shows_flat_faces(const std::string& aov, double most, const MapScale& scale) {
    return is_curvature(aov) && scale.diagonal > 0 &&
           most <= std::pow(kFlat / scale.diagonal, -map_spec(aov)->length_power);
}

/// The Gauss curvature of a ball as bent as the surface is in the middle, by the mean curvature:
/// half of its integral lies below, so that flat faces hardly count. A range below it shows what
/// the fit makes of cylinders and cones, on which it is 0. (Of a ball itself it is no less.)
double bent_as_a_ball(std::span<const float> mean, std::span<const std::uint8_t> hit) {
    // Bins of equal leading bits: less than a hundredth wide, in one pass instead of a sort.
    constexpr int kShift = 16;
    std::vector<double> sums(std::size_t{1} << (32 - kShift));
    for (std::size_t i = 0; i < mean.size(); ++i) {
        const float h = std::abs(mean[i]);
        if (hit[i] && std::isfinite(h))
            sums[std::bit_cast<std::uint32_t>(h) >> kShift] += static_cast<double>(h);
    }
    const double half = std::accumulate(sums.begin(), sums.end(), 0.0) / 2;
    double below = 0;
    for (std::uint32_t bin = 0; bin < sums.size(); ++bin) {
        if ((below += sums[bin]) < half || below == 0) continue;
        const auto h = static_cast<double>(std::bit_cast<float>(bin << kShift));
        return h * h;
    }
    return 0;
}

std::optional<double> parse_number(std::string_view text) {
    double value = 0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || rest != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

[[noreturn]] void bad_range(const std::string& entry) {
    static const std::vector<std::string> kMaps{
        "mean", "gauss", "k1", "k2", "e1", "e2", "dk1_dt2", "dk2_dt1", "depth", "error",
        "coverage", "truth_distance"};
    const std::string aov = entry.substr(0, entry.find('='));
    throw ConfigError(
        {.key = "range",
         .expected = fmt::format("A > 0, AOV=A or AOV=LO:HI with LO < HI for one of {}",
                                 fmt::join(kMaps, ", ")),
         .found = "'" + entry + "'",
         .hint = entry == aov || std::find(kMaps.begin(), kMaps.end(), aov) != kMaps.end()
                     ? ""
                     : did_you_mean(aov, kMaps)});
}

ValueRange parse_range(const std::string& entry, std::string_view value, bool is_signed) {
    const std::size_t colon = value.find(':');
    if (colon == std::string_view::npos) {
        const auto a = parse_number(value);
        if (!a || !(*a > 0)) bad_range(entry);
        return {is_signed ? -*a : 0.0, *a};
    }
    const auto lo = parse_number(value.substr(0, colon)),
               hi = parse_number(value.substr(colon + 1));
    if (!lo || !hi || !(*lo < *hi)) bad_range(entry);
    return {*lo, *hi};
}

/// The last entry of --range that speaks of this AOV; one that names it wins over one for all.
std::optional<ValueRange> fixed_range(const RenderConfig& config, const std::string& aov) {
    std::optional<ValueRange> general, own;
    for (const std::string& entry : config.range) {
        const std::size_t equals = entry.find('=');
        const bool is_general = equals == std::string::npos;
        if (!is_general && entry.substr(0, equals) != aov) continue;
        const auto value = std::string_view(entry).substr(is_general ? 0 : equals + 1);
        (is_general ? general : own) = parse_range(entry, value, map_spec(aov)->is_signed);
    }
    return own ? own : general;
}

}  // namespace

const MapSpec* map_spec(const std::string& aov) {
    const auto it = specs().find(aov);
    return it == specs().end() ? nullptr : &it->second;
}

void check_ranges(const RenderConfig& config) {
    for (const std::string& camera : config.same_range)
        if (!is_camera_name(camera))
            throw ConfigError({.key = "same_range",
                               .expected = fmt::format("named cameras ({})",
                                                       fmt::join(camera_names(), ", ")),
                               .found = "'" + camera + "'",
                               .hint = did_you_mean(camera, camera_names())});
    for (const std::string& entry : config.range) {
        const std::size_t equals = entry.find('=');
        const std::string aov = equals == std::string::npos ? "mean" : entry.substr(0, equals);
        if (!map_spec(aov)) bad_range(entry);
        fixed_range(config, aov);
    }
}

ValueRange map_range(const RenderConfig& config, const std::string& aov,
                     std::span<const float> values, const GBuffer& b,
                     const MapScale& scale) {
    const MapSpec& spec = *map_spec(aov);
    if (const auto fixed = fixed_range(config, aov)) return {fixed->lo, fixed->hi, spec.is_signed};
    if (aov == "depth") return full_range(values, b.hit);
    double least = least_range(aov, spec.length_power, scale);
    if (aov == "gauss") least = std::max(least, bent_as_a_ball(b.mean, b.hit));
    const double flat = flat_until(aov, spec.length_power, scale);
    const double most = percentile_of_abs(values, b.hit, config.percentile, flat);
    if (shows_flat_faces(aov, most, scale))
        least = std::max(least, std::pow(kMostOfFit / scale.diagonal, -spec.length_power));
    const ValueRange range = symmetric_range(most, least);
    return {spec.is_signed ? range.lo : 0, range.hi, spec.is_signed};
}

Legend make_legend(const RenderConfig& config, const std::string& aov, const ValueRange& range,
                   std::span<const float> values, std::span<const std::uint8_t> hit) {
    const MapSpec& spec = *map_spec(aov);
    Legend legend{spec.title, unit_text(config.unit, spec.length_power),
                  spec.is_signed ? &cool_warm() : aov == "coverage" ? &cividis() : &viridis(),
                  range, spec.high_note, spec.low_note};
    // A side of 0 that is not shown has no name.
    if (spec.is_signed && range.hi <= 0) legend.high_note.clear();
    if (spec.is_signed && range.lo >= 0) legend.low_note.clear();
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!hit[i]) continue;
        const double tolerance = 1e-6 * (range.hi - range.lo);
        legend.clipped_high |= values[i] > range.hi + tolerance;
        legend.clipped_low |= values[i] < range.lo - tolerance;
    }
    return legend;
}

ColorMap stepped_viridis(int n) {
    std::vector<Vec3f> knots(ColorMap::kKnots);
    for (std::size_t i = 0; i < knots.size(); ++i) {
        const int step = std::min(n - 1, static_cast<int>(i) * n / static_cast<int>(knots.size()));
        knots[i] = viridis().srgb(n > 1 ? static_cast<float>(step) / static_cast<float>(n - 1) : 0);
    }
    return ColorMap("viridis steps", knots);
}

}  // namespace slim
