#pragma once

#include "slim/base/vec.h"
#include "slim/neighbors/nearest.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace slim {

/// What tells whether coordinates come in steps that are noise (notes/0023): those of depth maps,
/// of voxels, and of files with few decimals. Neighbours on one step lie on a plane exactly, so
/// that a plane through ten of them, or their differences, show nothing of it. Points that were
/// sampled on a grid have steps, too, but lie on their surface. Counts add up over slices.
struct CoordinateSteps {
    struct Axis {
        std::size_t n = 0;   ///< of n_rounded: where its steps are along the normal
        double sq_step = 0;  ///< mean over these, length^2
    };
    std::size_t n_sampled = 0;
    std::size_t n_stepped = 0;  ///< of these: where coordinates along the normal take three steps
                                ///< and more, each many times
    std::size_t n_rounded = 0;  ///< of these: where points lie off a quadric by as much as the
                                ///< steps make, the nearer ones as well
    double variance = 0;        ///< mean over these of step^2 / 12 along the normal, length^2
    double off = 0;             ///< of how far the nearer points lie off, squared: of these steps
                                ///< and of noise beside them, as neighbours of one step hide it
    std::array<Axis, 3> axes;

    CoordinateSteps& operator+=(const CoordinateSteps& other);

    /// Whether enough of the samples see steps.
    bool are_told() const;
    bool are_noise() const;
    /// Variance of a point along its surface's normal that the steps make, typically; 0 unless they
    /// are noise.
    double step_variance() const { return are_noise() ? variance : 0; }
    /// The same with the noise that was rounded.
    double noise_variance() const { return are_noise() ? off : 0; }
    /// Along a unit normal: step^2 / 12 along each axis.
    double noise_variance(const Vec3d& normal) const;
};

/// Samples of a whole cloud that tell enough.
inline constexpr std::size_t kStepSamples = 250;

/// samples: points of the search all over the cloud. Where few of them see steps, which are wide on
/// gentle slopes, every fourth point is looked at in place of all, then every sixteenth, ...; what
/// is seen last counts. Cost: a search for 16 neighbours of each, and where many of these have
/// coordinates in common one for 640, a few times over; 24 MB for the fewer points.
CoordinateSteps coordinate_steps(const NearestSearch& search,
                                 std::span<const std::uint32_t> samples);

}  // namespace slim
