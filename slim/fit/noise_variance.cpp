#include "slim/fit/noise_variance.h"

#include "slim/normals/covariance.h"

#include <algorithm>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kFew = 1000;  // samples that every mean is over, if there are so many

/// The mean over the first n samples.
NoiseVariance with_neighbors(const NearestSearch& search, std::span<const std::uint32_t> samples,
                             std::size_t k, std::size_t n) {
    std::vector<std::uint32_t> wanted(samples.begin(),
                                      samples.begin() + static_cast<std::ptrdiff_t>(n));
    std::sort(wanted.begin(), wanted.end());
    struct Flatness {
        double smallest = 0, ratio = 0;
        bool known = false;
    };
    std::vector<Flatness> found(n);
    search.for_each(wanted, k, [&](std::size_t w, std::span<const std::uint32_t> neighbors) {
        if (neighbors.size() < 3) return;
        const Spread s = spread_of(search.positions(), neighbors);
        found[w] = {s.smallest, s.middle > 0 ? s.smallest / s.middle : 0, true};
    });
    NoiseVariance out;
    out.neighbors = k;
    for (const Flatness& f : found) {  // in one order, so threads do not matter
        out.value += f.smallest;
        out.flatness += f.ratio;
        out.n_sampled += f.known ? 1 : 0;
    }
    if (out.n_sampled > 0) {
        out.value /= static_cast<double>(out.n_sampled);
        out.flatness /= static_cast<double>(out.n_sampled);
    }
    return out;
}

/// A mean over fewer samples the more neighbours each has: the cost does not grow with k.
std::size_t enough_samples(std::size_t n, std::size_t k) {
    return std::min(n, std::max(n * 10 / k, kFew));
}

/// At the first k whose neighbourhoods are flat, which of the larger k shows on a tenth of the samples.
NoiseVariance with_flat_neighbors(const NearestSearch& search,
                                  std::span<const std::uint32_t> samples) {
    NoiseVariance out;
    for (const std::size_t k : kNoiseNeighbors) {
        const bool first = k == kNoiseNeighbors[0], last = k == std::end(kNoiseNeighbors)[-1];
        const std::size_t all = enough_samples(samples.size(), k);
        const std::size_t n = first || last ? all : std::min(samples.size(), std::max(all / 10, kFew));
        out = with_neighbors(search, samples, k, n);
        if (!last && k < search.size() && out.flatness > kFlat) continue;
        return n == all ? out : with_neighbors(search, samples, k, all);
    }
    return out;
}

/// The samples with each replaced by the first point at its place, and every place once, at its highest priority.
std::vector<std::uint32_t> distinct_places(const NearestSearch& search,
                                           std::span<const std::uint32_t> samples) {
    std::vector<std::uint32_t> first(search.size());
    for (std::uint32_t i = 0; i < first.size(); ++i) first[i] = search.is_repeat(i) ? first[i - 1] : i;
    std::vector<bool> taken(search.size(), false);
    std::vector<std::uint32_t> places;
    places.reserve(samples.size());
    for (const std::uint32_t i : samples) {
        if (taken[first[i]]) continue;
        taken[first[i]] = true;
        places.push_back(first[i]);
    }
    return places;
}

}  // namespace

NoiseVariance estimate_noise_variance(const NearestSearch& search,
                                      std::span<const std::uint32_t> samples,
                                      std::size_t neighbors) {
    const std::vector<std::uint32_t> places = distinct_places(search, samples);
    if (neighbors == 0) return with_flat_neighbors(search, places);
    return with_neighbors(search, places, neighbors, enough_samples(places.size(), neighbors));
}

}  // namespace slim
