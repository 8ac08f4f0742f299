#pragma once

#include <cstdint>
#include <map>

namespace slim {

/// Local variances counted and added up in bins a quarter of an octave wide, so that slices can be
/// joined and what a few samples make of the mean can be taken out of it afterwards. Bins begin at
/// powers of two: values scaled by one fall alike.
class VarianceBins {
public:
    struct Bin {
        std::uint64_t n = 0;
        double variance = 0, flatness = 0;  ///< sums
    };

    /// flatness: of the same neighbourhood
    void add(double variance, double flatness) { add(bin_of(variance), {1, variance, flatness}); }
    void add(int bin, const Bin& more);
    const std::map<int, Bin>& bins() const { return bins_; }

    /// Upper end of the bin that holds the value which a share in (0, 1] of all does not exceed; 0
    /// without values.
    double quantile(double share) const;
    /// Means over the bins that do not begin above `most`, and how many samples those hold.
    Bin mean_up_to(double most) const;

private:
    static int bin_of(double variance);
    static double begin_of(int bin);

    std::map<int, Bin> bins_;
};

}  // namespace slim
