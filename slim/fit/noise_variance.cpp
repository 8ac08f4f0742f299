#include "slim/fit/noise_variance.h"

#include "slim/fit/normal_variance.h"
#include "slim/normals/covariance.h"
#include "slim/normals/scan_line.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kFew = kFewestSamples;

// of the squared spacing: below it a neighbourhood is flat
constexpr double kRounding = 1e-12;

/// 0 of a plane, 1 of a ball and of a line of a scan whose next ones are far (normals notes/0005).
double flatness_of(const Spread& s) {
    if (!(s.largest > 0)) return 0;
    return is_on_line(s) ? 1 : s.smallest / s.middle;
}

// Strays are fewer, and so many times the variance that all others stay below.
constexpr double kMostStrays = 0.05, kBeyondOthers = 32;
// Of the squared reach of a usual neighbourhood: a ball filled evenly shows 0.2, a right angle at
// most 0.035, corners and plates that are not told apart up to twice that.
constexpr double kNoSurface = 0.1, kNoEdge = 0.0625;
constexpr double kOfParts = 0.5;  // what is no edge makes more of the mean: noise of a part
// The mean over the median where noise is the same everywhere is 1.1 to 1.7.
constexpr double kOfMedian = 4;
// of the squared spacing: what bends and edges make of lambda on clean scans, 0.003 to 0.008
constexpr double kOfEdges = 0.005;

/// The mean over the first n samples.
NoiseVariance with_neighbors(const NearestSearch& search, std::span<const std::uint32_t> samples,
                             std::size_t k, std::size_t n, std::span<const Vec3f> normals = {}) {
    std::vector<std::uint32_t> wanted(samples.begin(),
                                      samples.begin() + static_cast<std::ptrdiff_t>(n));
    std::sort(wanted.begin(), wanted.end());
    struct Flatness {
        double smallest = 0, ratio = 0, sq_reach = 0, normal = 0;
        bool known = false, line = false;
    };
    std::vector<Flatness> found(n);
    // A noisy scan line is flat in the plane of its noise, which is not that of the normals.
    const auto is_strip = [&](const Spread& s, std::uint32_t i) {
        return !normals.empty() && is_flat(s) && is_other_plane(s, to_double(normals[i]));
    };
    search.for_each(wanted, k, [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
        if (neighbors.size() < 3) return;
        const Spread s = spread_of(search.positions(), neighbors);
        const double sq_reach = sq_reach_of(search.positions(), wanted[w], neighbors);
        found[w] = {s.smallest, is_strip(s, wanted[w]) ? 1 : flatness_of(s),
                    sq_reach / static_cast<double>(neighbors.size()),
                    normals.empty()
                        ? 0
                        : normal_variance_of(search.positions(), normals, neighbors, s.normal),
                    true, is_on_line(s)};
    });
    NoiseVariance out;
    out.neighbors = k;
    double log_sq_reach = 0, log_normal = 0, log_smallest = 0;
    for (const Flatness& f : found) {  // in one order, so threads do not matter
        out.value += f.smallest;
        out.flatness += f.ratio;
        out.n_sampled += f.known ? 1 : 0;
        out.line_share += f.line ? 1 : 0;
        if (f.known) out.bins.add(f.smallest, f.ratio);
        if (f.known) log_sq_reach += std::log(f.sq_reach);  // at distinct places: positive
        if (f.known) log_smallest += std::log(std::max(f.smallest, kRounding * f.sq_reach));
        if (f.known && !normals.empty()) log_normal += std::log(f.normal);
    }
    if (out.n_sampled > 0) {
        out.value /= static_cast<double>(out.n_sampled);
        out.flatness /= static_cast<double>(out.n_sampled);
        out.line_share /= static_cast<double>(out.n_sampled);
        const double mean = log_sq_reach / static_cast<double>(out.n_sampled);
        out.spacing = std::sqrt(std::numbers::pi * std::exp(mean));
        out.typical = std::exp(log_smallest / static_cast<double>(out.n_sampled));
        if (!normals.empty())
            out.normal = std::exp(log_normal / static_cast<double>(out.n_sampled));
    }
    return out;
}

/// A mean over fewer samples the more neighbours each has: the cost does not grow with k.
std::size_t enough_samples(std::size_t n, std::size_t k, std::size_t fewest) {
    return std::min(n, std::max(n * 10 / k, fewest));
}

struct FlatNeighbors {
    std::size_t k = kNoiseNeighbors[0];
    double line_share = 0;  ///< with the fewest
};

/// The first k whose neighbourhoods are flat, which shows on a tenth of the samples;
/// else the flattest.
FlatNeighbors flat_neighbors(const NearestSearch& search, std::span<const std::uint32_t> samples,
                             std::span<const Vec3f> normals) {
    FlatNeighbors best;
    double flattest = INFINITY;
    for (const std::size_t k : kNoiseNeighbors) {
        if (k >= search.size()) break;
        const std::size_t n = std::min(samples.size(), std::max(samples.size() / k, kFew));
        const NoiseVariance noise = with_neighbors(search, samples, k, n, normals);
        const double flatness = robust_noise(noise).flatness;
        if (k == kNoiseNeighbors[0]) best.line_share = noise.line_share;
        if (flatness < flattest) best.k = k, flattest = flatness;
        if (flatness <= kFlat) break;
    }
    return best;
}

/// The first point at the place of each sample. Samples of one place look at its points once in
/// all.
std::vector<std::uint32_t> first_points(const NearestSearch& search,
                                        std::span<const std::uint32_t> samples) {
    std::vector<std::uint32_t> first(samples.begin(), samples.end());
    const auto may_repeat = [&](std::uint32_t i) {
        return search.has_repeats(i / BoxTree::kBucket) && search.is_repeat(i);
    };
    if (std::none_of(samples.begin(), samples.end(), may_repeat)) return first;
    std::vector<std::uint32_t> order(samples.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return samples[a] < samples[b]; });
    for (std::size_t k = 0; k < order.size(); ++k) {
        std::uint32_t& i = first[order[k]];
        while (search.is_repeat(i) && (k == 0 || i != samples[order[k - 1]])) --i;
        if (k > 0 && i == samples[order[k - 1]]) i = first[order[k - 1]];
    }
    return first;
}

/// The samples with each replaced by the first point at its place, and every place once, at its
/// highest priority. Cost: of the samples, and a bit of each point.
std::vector<std::uint32_t> distinct_places(const NearestSearch& search,
                                           std::span<const std::uint32_t> samples) {
    std::vector<bool> taken(search.size());
    std::vector<std::uint32_t> places;
    places.reserve(samples.size());
    for (const std::uint32_t first : first_points(search, samples)) {
        if (taken[first]) continue;
        taken[first] = true;
        places.push_back(first);
    }
    return places;
}

/// Squared reach of a usual neighbourhood.
double usual_sq_reach(const NoiseVariance& noise) {
    const double sq_spacing = noise.spacing * noise.spacing;
    return static_cast<double>(noise.neighbors) * sq_spacing / std::numbers::pi;
}

}  // namespace

NoiseVariance estimate_noise_variance(const NearestSearch& search,
                                      std::span<const std::uint32_t> samples, std::size_t neighbors,
                                      std::span<const Vec3f> normals, std::size_t fewest) {
    const std::vector<std::uint32_t> places = distinct_places(search, samples);
    const FlatNeighbors flat =
        neighbors > 0 ? FlatNeighbors{neighbors} : flat_neighbors(search, places, normals);
    const std::size_t k = flat.k;
    NoiseVariance out =
        with_neighbors(search, places, k, enough_samples(places.size(), k, fewest), normals);
    if (neighbors == 0) out.line_share = flat.line_share;
    if (!normals.empty() && normals_inform(out.typical, out.normal, out.spacing))
        out.independence = normal_independence(search, places, normals, k);
    return out;
}

double stray_share(const NoiseVariance& noise) {
    if (noise.n_sampled == 0) return 0;
    const double most =
        std::max(kBeyondOthers * noise.bins.quantile(0.5), kNoSurface * usual_sq_reach(noise));
    const double others = static_cast<double>(noise.bins.mean_up_to(most).n);
    return 1 - others / static_cast<double>(noise.n_sampled);
}

RobustNoise robust_noise(const NoiseVariance& noise) {
    const double sq_spacing = noise.spacing * noise.spacing;
    const double sq_reach = usual_sq_reach(noise);
    const VarianceBins& bins = noise.bins;
    const VarianceBins::Bin others = bins.mean_up_to(
        std::max(kBeyondOthers * bins.quantile(1 - kMostStrays), kNoSurface * sq_reach));
    RobustNoise out{noise.value, noise.flatness};
    if (others.n < noise.n_sampled) out = {others.variance, others.flatness};
    const double most = std::max(kOfMedian * bins.quantile(0.5), kOfEdges * sq_spacing);
    if (out.variance <= most) return out;
    const VarianceBins::Bin edges = bins.mean_up_to(kNoEdge * sq_reach);
    const double share_of_edges = edges.variance * static_cast<double>(edges.n) /
                                  (others.variance * static_cast<double>(others.n));
    if (share_of_edges < 1 - kOfParts) out = {most, bins.mean_up_to(most).flatness};
    return out;
}

}  // namespace slim
