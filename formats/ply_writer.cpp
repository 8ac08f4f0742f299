#include "formats/ply_writer.h"

#include "formats/message.h"
#include "slim/base/check.h"

#include <charconv>
#include <cstring>
#include <type_traits>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kCountDigits = 20;

/// The shortest text that reads back as the same number.
template <class T>
std::string shortest(T value) {
    char text[64];
    const auto result = std::to_chars(text, text + sizeof(text), value);
    return {text, result.ptr};
}

void check_columns(const PlyLayout& layout, const PlyPoints& points) {
    const std::size_t n = points.position.size();
    if (layout.normals) SLIM_CHECK(points.normal.size(), ==, n);
    if (layout.colours) SLIM_CHECK(points.colour.size(), ==, 3 * n);
    if (layout.scan) SLIM_CHECK(points.scan.size(), ==, n);
    SLIM_CHECK(points.scalars.size(), ==, layout.scalars.size() * n);
}

}  // namespace

PlyWriter::PlyWriter(const std::string& path, PlyLayout layout)
    : file_(path), layout_(std::move(layout)) {
    file_.write(header());
}

/// Of the same length for any count: the blanks stand behind a comment, where they hurt no reader.
std::string PlyWriter::header() const {
    const std::string count = std::to_string(n_points_);
    std::string text = message("ply\nformat ", layout_.ascii ? "ascii" : "binary_little_endian",
                               " 1.0\ncomment slim",
                               std::string(kCountDigits - count.size(), ' '), '\n');
    if (layout_.origin)
        text += message("comment slim origin ", shortest(layout_.origin->x), ' ',
                        shortest(layout_.origin->y), ' ', shortest(layout_.origin->z), '\n');
    for (const std::string& comment : layout_.comments) text += "comment " + comment + '\n';
    text += "element vertex " + count + '\n';
    const auto property = [&](const char* type, const std::string& name) {
        text += message("property ", type, ' ', name, '\n');
    };
    for (const char* name : {"x", "y", "z"})
        property(layout_.double_positions ? "double" : "float", name);
    if (layout_.normals)
        for (const char* name : {"nx", "ny", "nz"}) property("float", name);
    if (layout_.colours)
        for (const char* name : {"red", "green", "blue"}) property("uchar", name);
    if (layout_.scan) property("ushort", "scan");
    for (const std::string& name : layout_.scalars) property("float", name);
    if (layout_.n_faces)
        text += message("element face ", *layout_.n_faces, "\nproperty list ",
                        layout_.large_faces ? "int" : "uchar", " int vertex_indices\n");
    return text + "end_header\n";
}

template <class T>
void PlyWriter::put(T value) {
    if (!layout_.ascii) {
        char bytes[sizeof(T)];
        std::memcpy(bytes, &value, sizeof(T));
        row_.insert(row_.end(), bytes, bytes + sizeof(T));
        return;
    }
    if (!row_.empty()) row_.push_back(' ');
    std::string text;
    if constexpr (std::is_integral_v<T>) text = std::to_string(value);
    else text = shortest(value);
    row_.insert(row_.end(), text.begin(), text.end());
}

void PlyWriter::put_record(const PlyPoints& points, std::size_t i) {
    row_.clear();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double value = points.position[i][axis];
        if (layout_.double_positions) put(value);
        else put(static_cast<float>(value));
    }
    if (layout_.normals)
        for (std::size_t axis = 0; axis < 3; ++axis) put(points.normal[i][axis]);
    if (layout_.colours)
        for (std::size_t k = 0; k < 3; ++k) put(points.colour[3 * i + k]);
    if (layout_.scan) put(points.scan[i]);
    const std::size_t n_scalars = layout_.scalars.size();
    for (std::size_t k = 0; k < n_scalars; ++k) put(points.scalars[n_scalars * i + k]);
    if (layout_.ascii) row_.push_back('\n');
    file_.write(row_.data(), row_.size());
}

void PlyWriter::write(const PlyPoints& points) {
    check_columns(layout_, points);
    for (std::size_t i = 0; i < points.position.size(); ++i) put_record(points, i);
    n_points_ += points.position.size();
}

void PlyWriter::write_face(std::span<const std::uint32_t> corners) {
    row_.clear();
    if (!layout_.large_faces) SLIM_CHECK(corners.size(), <, 256u);
    if (layout_.large_faces) put(static_cast<std::int32_t>(corners.size()));
    else put(static_cast<std::uint8_t>(corners.size()));
    for (const std::uint32_t v : corners) put(static_cast<std::int32_t>(v));
    if (layout_.ascii) row_.push_back('\n');
    file_.write(row_.data(), row_.size());
    ++n_faces_;
}

void PlyWriter::commit() {
    SLIM_CHECK(n_faces_, ==, layout_.n_faces.value_or(0));
    const std::string text = header();
    file_.write_at(0, text.data(), text.size());
    file_.commit();
}

}  // namespace slim
