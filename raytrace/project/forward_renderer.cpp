#include "raytrace/project/forward_renderer.h"

#include "raytrace/project/forward_picture.h"

namespace slim {

RenderStats render_forward(const SurfelTree& tree, const RenderRequest& request, GBuffer& out,
                           const SampleMask* only) {
    return ForwardPicture(tree, request, only).draw(request.resolved_window(), out);
}

}  // namespace slim
