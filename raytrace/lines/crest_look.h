#pragma once

#include "raytrace/camera.h"
#include "raytrace/lines/crossings.h"
#include "raytrace/lines/feature_line.h"
#include "raytrace/lines/line_scene.h"

#include <cstddef>
#include <vector>

namespace slim {

/// Where a crossing of a crest line looks for the fall of its curvature.
struct CrestLook {
    Vec3f normal;
    Vec3f along;  ///< t1 of ridges, t2 of valleys; zero: an edge
                  ///< within a pixel, of which nothing is asked
};

/// That of a crossing as crest_crossings has found it.
CrestLook crest_look(const LineScene& scene, const Crossing& crossing, bool ridges);

/// The curvatures of a picture at every few pixels (800 of its shorter side at the most), gathered
/// band by band: what tells crest lines from waves of the fit lies as far off as the normal turns
/// by 40 degrees, which may be anywhere in the picture. 24 bytes a sample, 27 MB for a picture of
/// 16 : 9 of any size.
class CurvatureSamples {
public:
    /// Those of the rows that are searched; the first call sets the picture. cost O(samples)
    void add(const LineScene& scene);

    /// Sharpness of a crest line at p: the -k''/k^3 that makes k (k1, of valleys -k2) fall as it
    /// does to either side of the line until the normal has turned by 40 degrees; the lesser of the
    /// sides that are seen. 0 on a torus, about 3 (1 - b^2/a^2) at the tip of an ellipse, in [-1,
    /// 4]. NaN where neither side is seen. cost O(1)
    /// Departs from NUMERICS 5.4, which has no such test: e alone has false zeros at every surfel.
    float sharpness(const LinePoint& p, const CrestLook& look, bool ridge) const;

    struct Sample {
        Vec3f point;
        float k1, k2;  ///< NaN: no surface
        float error;   ///< RMS residual of the surfel, model units; 0 where the frame does not say
    };
    /// The sample of a place of the picture, pixels; none outside.
    const Sample* at(float x, float y) const;
    /// Width of a pixel at a point, model units.
    float footprint(const Vec3f& point) const;
    std::size_t step_px() const { return step_; }

private:
    float fall_along(const Vec3f& q, const CrestLook& look, float k, float turn, bool ridge) const;
    float fall_at(const Vec3f& p, const Vec3f& q, float k, bool ridge) const;

    PixelView view_;
    std::vector<Sample> samples_;
    std::size_t step_ = 0;  ///< pixels from one sample to the next
    std::size_t width_ = 0, height_ = 0;  ///< of samples
    float near_px_ = 3;  ///< the nearest look
};

}  // namespace slim
