#pragma once

#include <string>

namespace slim {

/// --face-points, of `slim slice` and of all that begins with it (formats/face_points.h).
template <class Visitor>
void visit_face_points(Visitor& field, std::string& face_points) {
    field.choice("face_points", face_points,
                 "on: a mesh's large faces (as wide as five of its median edges, or a twelfth of "
                 "the diagonal) get points of their own, denser where it is thin or its parts are "
                 "small; off: its vertices alone",
                 {"on", "off"});
}

}  // namespace slim
