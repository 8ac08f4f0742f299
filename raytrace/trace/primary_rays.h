#pragma once

#include "raytrace/camera.h"
#include "raytrace/pixel_block.h"
#include "raytrace/scene_frame.h"
#include "raytrace/trace/ray_packet.h"

namespace slim {

/// Rays through the centres of a block's pixels, from where they enter the scene on; lanes that
/// miss its sphere have none.
RayPacket primary_rays(const PixelView& view, const SceneFrame& frame, const PixelBlock& block);

/// The same towards a ground, which goes on outside that sphere: from no farther before the scene's
/// middle than it matters.
RayPacket rays_to_ground(const PixelView& view, const SceneFrame& frame, const PixelBlock& block);

}  // namespace slim
