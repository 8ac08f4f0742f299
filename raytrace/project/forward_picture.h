#pragma once

#include "raytrace/frame.h"
#include "raytrace/renderer.h"
#include "raytrace/sample_mask.h"
#include "slim/blend/leaf_hessians.h"
#include "slim/model/surfel_tree.h"

#include <memory>

namespace slim {

/// A picture made ready by forward projection, the surfels of its cut sorted into tiles, to be
/// drawn window by window. What render_forward says of a picture holds of each window.
class ForwardPicture {
public:
    /// The request's window is all that can be drawn. The tree, and `only` if given (see
    /// render_forward), must outlive this.
    /// throws  ConfigError for the camera, the size or the window; FormatError for a tree with
    ///         cycles
    /// cost    O(nodes above the cut + cut); with `only` a surfel that reaches no tile with a
    ///         wanted sample is left out early
    ForwardPicture(const SurfelTree& tree, const RenderRequest& request,
                   const SampleMask* only = nullptr);
    ~ForwardPicture();
    ForwardPicture(const ForwardPicture&) = delete;
    ForwardPicture& operator=(const ForwardPicture&) = delete;

    /// A window of it; several may be drawn at the same time. `out` is reset to the window and the
    /// request's channels. Times and counts of the cut are those of the whole.
    /// cost  O(tiles of the window + covered pixels x overlap)
    RenderStats draw(const PixelWindow& window, GBuffer& out) const;

private:
    class Ready;
    template <int Degree>
    class ReadyOf;

    Channels wanted_;
    RenderStats stats_;  ///< of the cut
    std::unique_ptr<LeafHessians> own_hessians_;  ///< if the request has none
    std::unique_ptr<Ready> ready_;
};

}  // namespace slim
