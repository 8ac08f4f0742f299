#pragma once

#include <Imath/ImathBox.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfPixelType.h>

#include <cstddef>

namespace slim {

/// A slice of contiguous rows of T for the data window; the library only reads through the pointer
/// when it writes a file.
template <class T>
Imf::Slice plane(Imf::PixelType type, const T* values, const Imath::Box2i& data) {
    const auto width = static_cast<std::size_t>(data.max.x - data.min.x + 1);
    return Imf::Slice::Make(type, const_cast<T*>(values), data, sizeof(T), sizeof(T) * width);
}

}  // namespace slim
