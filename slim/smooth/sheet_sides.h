#pragma once

#include "slim/model/point_block.h"
#include "slim/tree/ball_index.h"

namespace slim {

/// Points without a normal that lie between sheets of a model that face away from each other, as
/// the sides of a thin plate, get the unit normal of the nearer one: fits made anew then leave the
/// points of the other out. All others are left as they are, as is a block where no leaf holds the
/// centre of one that faces away. Cost: 1 us a point and core where any does.
void tell_sheets_apart(const BallIndex& model, PointBlock& points);

}  // namespace slim
