#pragma once

#include "raytrace/height_label.h"
#include "raytrace/hillshade.h"
#include "raytrace/lines/height_line.h"
#include "raytrace/panel.h"

#include <span>
#include <string>
#include <vector>

namespace slim {

/// The picture that heights are written on.
struct LabelSheet {
    int width = 0, height = 0;    ///< pixels
    std::string unit;             ///< after each number; may be empty
    std::vector<PixelBox> taken;  ///< legends and scale bar
};

/// Heights of the index contours of a view and where they stand; the same for all parts of the
/// picture, as they come from a frame of the whole (which may be smaller) and a fixed rule:
///
/// - a line longer than three labels has one, and another for each 15 more;
/// - of each such stretch the label takes the place where the line is straightest, deviates by less
///   than a third of a digit's height, near the middle of the stretch;
/// - heads of digits are uphill where that leaves them upright, and places where it does come
///   first; a line that has none is labelled all the same, upright, heads downhill;
/// - all of the label lies on the surface, between the index contours next to its own, off the
///   frame, the legends and the other labels; equal heights are five labels apart;
/// - the longest lines choose first.
///
/// relief   its spacing is that of all lines; nothing is labelled where it is 0
/// throws   nothing; a frame without positions and normals is a SLIM_CHECK failure
/// cost     O(pixels of the frame + length of the lines x width of a label)
std::vector<HeightLabel> place_height_labels(const LineScene& frame, const Relief& relief,
                                             const LabelSheet& sheet);

}  // namespace slim
