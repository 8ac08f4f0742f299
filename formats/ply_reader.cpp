#include "formats/ply_reader.h"

#include "formats/message.h"
#include "formats/ply_number.h"
#include "slim/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slim {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 19;

/// store(i, value) for number i of a column: `from` is its first byte, rows are `stride` apart.
template <class Store>
void decode_column(const char* from, std::size_t stride, std::size_t n, PlyType type, bool swap,
                   const Store& store) {
    with_ply_type(type, [&]<class T>(T) {
        for (std::size_t i = 0; i < n; ++i, from += stride) store(i, load_number<T>(from, swap));
    });
}

const char* encoding_name(PlyEncoding encoding) {
    return encoding == PlyEncoding::ascii           ? "PLY ascii"
           : encoding == PlyEncoding::little_endian ? "PLY binary little endian"
                                                    : "PLY binary big endian";
}

CoordinateType coordinate_type(const PlyElement& vertex, const int (&position)[3]) {
    bool all_integer = true;
    bool any_double = false;
    for (const int p : position) {
        const PlyType type = vertex.properties[static_cast<std::size_t>(p)].type;
        all_integer = all_integer && is_integer(type);
        any_double = any_double || type == PlyType::f64;
    }
    if (all_integer) return CoordinateType::integer;
    return any_double ? CoordinateType::float64 : CoordinateType::float32;
}

}  // namespace

int ply_corner_list(const PlyElement& face) {
    for (std::size_t i = 0; i < face.properties.size(); ++i) {
        const PlyProperty& p = face.properties[i];
        if (p.is_list && p.name.rfind("vertex_ind", 0) == 0) return static_cast<int>(i);
    }
    return -1;
}

PlyReader::PlyReader(const std::string& path) : in_(path), header_(read_ply_header(in_)) {
    find_vertex_element();
    find_columns();
    describe();
    for (const PlyElement& element : header_.elements) {
        check_ply_count(in_, element, header_.encoding);
        if (&element == vertex_) break;
        PlyRows(in_, header_, element).skip_all();
    }
    const auto size = vertex_->fixed_size();
    if (header_.encoding != PlyEncoding::ascii && size) record_size_ = *size;
    else rows_ = std::make_unique<PlyRows>(in_, header_, *vertex_);
}

void PlyReader::find_vertex_element() {
    vertex_ = header_.find("vertex");
    if (!vertex_) vertex_ = header_.find("point");
    if (vertex_) return;
    std::string found;
    for (const PlyElement& e : header_.elements) found += (found.empty() ? "" : ", ") + e.name;
    throw FormatError(message(in_.path(), ": line ", in_.line_number(),
                              ": expected an element vertex (or point), found ",
                              found.empty() ? "no element" : found));
}

void PlyReader::find_columns() {
    const auto scalar = [&](const char* name) {
        const int i = vertex_->find(name);
        return i >= 0 && !vertex_->properties[static_cast<std::size_t>(i)].is_list ? i : -1;
    };
    const char* const positions[] = {"x", "y", "z"};
    const char* const normals[] = {"nx", "ny", "nz"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        columns_.position[axis] = scalar(positions[axis]);
        columns_.normal[axis] = scalar(normals[axis]);
        if (columns_.position[axis] < 0)
            throw FormatError(message(in_.path(), ": line ", in_.line_number(), ": element ",
                                      vertex_->name, " has no scalar property ", positions[axis]));
    }
    columns_.scan = scalar("scan");
    const char* const colors[] = {"red", "green", "blue"};
    const char* const others[] = {"diffuse_red", "diffuse_green", "diffuse_blue"};
    for (std::size_t c = 0; c < 3; ++c) {
        columns_.color[c] = scalar(colors[c]);
        if (columns_.color[c] < 0) columns_.color[c] = scalar(others[c]);
    }
}

bool PlyReader::ask_for_color() { return info_.reads_color = !info_.colors.empty(); }

float PlyReader::color_scale(std::size_t channel) const {
    switch (vertex_->properties[static_cast<std::size_t>(columns_.color[channel])].type) {
        case PlyType::i8:
            return 1.0f / 127;
        case PlyType::u8:
            return 1.0f / 255;
        case PlyType::i16:
            return 1.0f / 32767;
        case PlyType::u16:
            return 1.0f / 65535;
        case PlyType::f32:
        case PlyType::f64:
            return 1;
        default:
            return 1.0f / 255;  // ints hold bytes as others write them
    }
}

void PlyReader::describe() {
    info_.path = in_.path();
    info_.format = message(encoding_name(header_.encoding), in_.is_gzip() ? " gzip" : "");
    info_.n_points = vertex_->count;
    const auto& n = columns_.normal;
    info_.has_normals = n[0] >= 0 && n[1] >= 0 && n[2] >= 0;
    info_.has_scan = columns_.scan >= 0;
    const PlyElement* face = header_.find("face");
    info_.n_faces = face ? face->count : 0;
    info_.coordinates = coordinate_type(*vertex_, columns_.position);
    info_.origin = header_.origin;
    info_.noise_variance = header_.noise_variance;
    info_.file_size = in_.file_size();
    const auto& c = columns_.color;
    const bool has_color = c[0] >= 0 && c[1] >= 0 && c[2] >= 0;
    for (std::size_t i = 0; i < vertex_->properties.size(); ++i) {
        const int k = static_cast<int>(i);
        const bool in_color = has_color && (k == c[0] || k == c[1] || k == c[2]);
        const bool in_normal = info_.has_normals && (k == n[0] || k == n[1] || k == n[2]);
        const auto& p = columns_.position;
        const bool used = in_normal || k == columns_.scan || k == p[0] || k == p[1] || k == p[2];
        auto& names = used ? info_.carried : in_color ? info_.colors : info_.skipped;
        names.push_back(vertex_->properties[i].name);
    }
}

bool PlyReader::has_corner_lists() const {
    const PlyElement* face = header_.find("face");
    return face && ply_corner_list(*face) >= 0;
}

bool PlyReader::read(PointChunk& out, std::size_t max_points) {
    const auto n = static_cast<std::size_t>(
        std::min<std::uint64_t>(max_points, vertex_->count - n_read_));
    if (n == 0) {
        out.resize(0, info_);
        return false;
    }
    if (record_size_ > 0) read_records(out, n);
    else read_rows(out, n);
    n_read_ += out.size();
    if (info_.origin)
        for (Vec3d& p : out.position) p += *info_.origin;
    return true;
}

std::uint16_t PlyReader::scan_id(double value, std::uint64_t point) const {
    if (!(value >= 0 && value <= std::numeric_limits<std::uint16_t>::max()))
        throw FormatError(message(in_.path(), ": point ", point + 1, ": scan ", value,
                                  " is outside 0 to 65535"));
    return static_cast<std::uint16_t>(value);
}

void PlyReader::read_rows(PointChunk& out, std::size_t n) {
    // Grown as rows arrive: in a gzip file the declared count could not be checked.
    out.resize(0, info_);
    const auto at = [&](int column) { return rows_->scalars()[static_cast<std::size_t>(column)]; };
    for (std::size_t i = 0; i < n && rows_->next(); ++i) {
        const auto& p = columns_.position;
        out.position.push_back({at(p[0]), at(p[1]), at(p[2])});
        const auto& m = columns_.normal;
        if (info_.has_normals) out.normal.push_back(to_float(Vec3d{at(m[0]), at(m[1]), at(m[2])}));
        if (info_.has_scan) out.scan.push_back(scan_id(at(columns_.scan), n_read_ + i));
        const auto& c = columns_.color;
        if (info_.reads_color)
            out.color.push_back({static_cast<float>(at(c[0])) * color_scale(0),
                                 static_cast<float>(at(c[1])) * color_scale(1),
                                 static_cast<float>(at(c[2])) * color_scale(2)});
    }
}

PlyReader::Field PlyReader::field(int property) const {
    Field f;
    for (int i = 0; i < property; ++i)
        f.offset += size_of(vertex_->properties[static_cast<std::size_t>(i)].type);
    f.type = vertex_->properties[static_cast<std::size_t>(property)].type;
    return f;
}

void PlyReader::read_records(PointChunk& out, std::size_t n) {
    out.resize(std::min(out.size(), n), info_);  // what it held before need not be cleared
    const std::size_t block = std::max<std::size_t>(1, kBlockBytes / record_size_);
    for (std::size_t done = 0; done < n;) {
        const std::size_t wanted = std::min(block, n - done);
        const std::string_view bytes = in_.peek(wanted * record_size_);
        const std::size_t rows = std::min(wanted, bytes.size() / record_size_);
        if (rows == 0)
            throw FormatError(message(in_.path(), ": byte ", in_.offset(), ": the file ends after ",
                                      n_read_ + done, " of ", vertex_->count, " declared points"));
        if (out.size() < done + rows) out.resize(done + rows, info_);
        decode_records(bytes.data(), done, rows, out);
        in_.advance(rows * record_size_);
        done += rows;
    }
}

void PlyReader::decode_records(const char* rows, std::size_t first, std::size_t n,
                               PointChunk& out) const {
    const bool swap = header_.encoding == PlyEncoding::big_endian;
    const auto column = [&](int property, const auto& store) {
        const Field f = field(property);
        decode_column(rows + f.offset, record_size_, n, f.type, swap, store);
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        Vec3d* position = out.position.data() + first;
        column(columns_.position[axis],
               [&](std::size_t i, auto value) { position[i][axis] = static_cast<double>(value); });
        if (!info_.has_normals) continue;
        Vec3f* normal = out.normal.data() + first;
        column(columns_.normal[axis],
               [&](std::size_t i, auto value) { normal[i][axis] = static_cast<float>(value); });
    }
    for (std::size_t c = 0; info_.reads_color && c < 3; ++c) {
        Vec3f* color = out.color.data() + first;
        column(columns_.color[c], [&, scale = color_scale(c)](std::size_t i, auto value) {
            color[i][c] = static_cast<float>(value) * scale;
        });
    }
    if (!info_.has_scan) return;
    column(columns_.scan, [&](std::size_t i, auto value) {
        out.scan[first + i] = scan_id(static_cast<double>(value), n_read_ + first + i);
    });
}

}  // namespace slim
