#include "formats/ply_faces.h"

#include "formats/message.h"
#include "formats/ply_reader.h"
#include "formats/ply_rows.h"
#include "slim/base/error.h"

#include <cmath>
#include <vector>

namespace slim {
namespace {

std::size_t vertex_index(double value, std::size_t n_vertices, const std::string& path,
                         const PlyRows& rows) {
    if (value >= 0 && value < static_cast<double>(n_vertices) && std::floor(value) == value)
        return static_cast<std::size_t>(value);
    throw FormatError(message(path, ": ", rows.place(), ": face ", rows.n_read(),
                              " has vertex index ", value, ", but there are ", n_vertices,
                              " vertices"));
}

}  // namespace

void read_ply_faces(const std::string& path, std::size_t n_vertices,
                    const std::function<void(std::span<const std::size_t> corners)>& take) {
    // A reader of its own: faces may stand before the vertices.
    ByteReader in(path);
    const PlyHeader header = read_ply_header(in);
    std::vector<std::size_t> corners;
    for (const PlyElement& element : header.elements) {
        check_ply_count(in, element, header.encoding);
        if (element.name != "face") {
            PlyRows(in, header, element).skip_all();
            continue;
        }
        const int list = ply_corner_list(element);
        if (list < 0) return;
        PlyRows rows(in, header, element, list);
        while (rows.next()) {
            corners.clear();
            for (const double corner : rows.list())
                corners.push_back(vertex_index(corner, n_vertices, path, rows));
            take(corners);
        }
        return;
    }
}

}  // namespace slim
