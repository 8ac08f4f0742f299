#pragma once

#include "raytrace/canvas.h"
#include "raytrace/legend.h"
#include "raytrace/panel.h"

namespace slim {

/// The panel of a legend whose bar lies along the lower edge of a width x height picture, at the
/// right: a title, the notes over the bar's ends, the bar, and as many of its ticks' numbers as
/// stand beside each other.
PixelBox box_below(const Legend& legend, int width, int height);

/// Draws it.
void burn_below(const Legend& legend, const Canvas& canvas);

}  // namespace slim
