#pragma once

#include "formats/byte_reader.h"
#include "formats/ply_header.h"
#include "formats/ply_rows.h"
#include "formats/point_source.h"

#include <memory>
#include <string>
#include <vector>

namespace slim {

/// Index of the list that holds a face's corners: vertex_indices, vertex_index and the like; or -1.
int ply_corner_list(const PlyElement& face);

/// The vertices of a PLY in chunks. Elements before them are passed over, those behind not read.
class PlyReader : public PointSource {
public:
    explicit PlyReader(const std::string& path);
    bool read(PointChunk& out, std::size_t max_points) override;
    /// Whether its faces name their corners, so that normals can be made of them.
    bool has_corner_lists() const;
    /// Colours are read from now on; false if there are none.
    bool ask_for_color();
    std::uint64_t bytes_read() const override { return in_.file_bytes_read(); }

private:
    /// Property indices by what they mean; -1: none.
    struct Columns {
        int position[3] = {-1, -1, -1};
        int normal[3] = {-1, -1, -1};
        int scan = -1;
        int color[3] = {-1, -1, -1};
    };
    /// One number of a fixed binary row.
    struct Field {
        std::size_t offset = 0;
        PlyType type = PlyType::f32;
    };

    void find_vertex_element();
    void find_columns();
    void describe();
    void read_rows(PointChunk& out, std::size_t n);
    void read_records(PointChunk& out, std::size_t n);
    void decode_records(const char* rows, std::size_t first, std::size_t n, PointChunk& out) const;
    Field field(int property) const;
    std::uint16_t scan_id(double value, std::uint64_t point) const;
    /// What a channel is multiplied by to lie in 0 to 1.
    float color_scale(std::size_t channel) const;

    ByteReader in_;
    PlyHeader header_;
    const PlyElement* vertex_ = nullptr;
    Columns columns_;
    std::unique_ptr<PlyRows> rows_;     ///< for what is not a fixed binary record
    std::size_t record_size_ = 0;       ///< 0: read row by row
    std::uint64_t n_read_ = 0;
};

}  // namespace slim
