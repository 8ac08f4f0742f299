#pragma once

#include "slim/base/vec.h"

#include <vector>

namespace slim {

/// A picture of a ball whose colours a surface takes by its normals (lit sphere; Sloan et al.
/// 2001), linear Rec.709.
class Matcap {
public:
    /// rgb: 3 width height values, rows from the top; the ball fills the picture (as an ellipse if
    /// it is not square).
    Matcap(int width, int height, std::vector<float> rgb);

    /// A built-in ball: glazed clay with a cool rim.
    static Matcap glazed();

    /// normal and toward_eye: unit, camera axes; the rim of the ball is where the surface turns
    /// away from the eye, at the picture's edge as in its middle. Bilinear.
    Vec3f color(const Vec3f& normal, const Vec3f& toward_eye) const;

private:
    const float* texel(int x, int y) const {
        return &rgb_[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                          static_cast<std::size_t>(x))];
    }
    int width_, height_;
    std::vector<float> rgb_;
};

}  // namespace slim
