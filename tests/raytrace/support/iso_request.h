#pragma once

#include "raytrace/renderer.h"
#include "slim/model/surfel_tree.h"

namespace slim::test {

/// All channels of a model seen by the named camera iso, without levels of detail.
inline RenderRequest iso_request(const SurfelTreeData& model, int width, int height,
                                 bool orthographic) {
    RenderRequest request;
    Bbox box = model.header.bounds;
    Framing framing;
    framing.orthographic = orthographic;
    request.camera = named_camera("iso", box, double(width) / height, framing);
    request.width = width, request.height = height;
    request.wanted = kAllChannels;
    request.lod_px = 0;
    return request;
}

}  // namespace slim::test
