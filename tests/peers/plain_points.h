// Positions of a binary little-endian PLY, or of text with x y z first on a line, as doubles; and
// back as such a PLY.
#pragma once

#include <array>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace peers {

using Positions = std::vector<std::array<double, 3>>;

struct PlyColumn {
    std::size_t offset = 0, bytes = 0;
};

inline std::size_t bytes_of(const std::string& type) {
    if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
    if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
    if (type == "double" || type == "float64") return 8;
    return 4;
}

inline double value_at(const char* row, const PlyColumn& column) {
    if (column.bytes == 8) {
        double value;
        std::memcpy(&value, row + column.offset, 8);
        return value;
    }
    float value;
    std::memcpy(&value, row + column.offset, 4);
    return double(value);
}

/// The vertices must be the first element, without lists.
inline Positions read_ply(std::istream& in, const std::string& path) {
    std::string line, element, word, type, name;
    std::size_t n = 0, row_bytes = 0, found = 0;
    std::array<PlyColumn, 3> xyz;
    bool binary = false;
    while (std::getline(in, line) && line != "end_header") {
        std::istringstream words(line);
        words >> word;
        if (word == "format") words >> type, binary = type == "binary_little_endian";
        if (word == "element")
            words >> element >> name, n = element == "vertex" ? std::stoul(name) : n;
        if (word != "property" || element != "vertex") continue;
        words >> type >> name;
        if (name.size() == 1 && name[0] >= 'x' && name[0] <= 'z')
            xyz[std::size_t(name[0] - 'x')] = {row_bytes, bytes_of(type)}, ++found;
        row_bytes += bytes_of(type);
    }
    if (!binary || found != 3)
        throw std::runtime_error(path + ": no binary little-endian PLY with x, y, z");
    Positions points(n);
    std::vector<char> row(row_bytes);
    for (auto& point : points) {
        if (!in.read(row.data(), std::streamsize(row_bytes)))
            throw std::runtime_error(path + ": ends early");
        for (std::size_t i = 0; i < 3; ++i) point[i] = value_at(row.data(), xyz[i]);
    }
    return points;
}

inline Positions read_text(std::istream& in) {
    Positions points;
    std::string line;
    while (std::getline(in, line)) {
        std::istringstream words(line);
        std::array<double, 3> p{};
        if (words >> p[0] >> p[1] >> p[2]) points.push_back(p);
    }
    return points;
}

inline Positions read_positions(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::string first;
    if (!in || !std::getline(in, first)) throw std::runtime_error(path + ": cannot be read");
    if (first == "ply") return read_ply(in, path);
    in.seekg(0);
    return read_text(in);
}

inline bool write_positions(const std::string& path, const Positions& points) {
    std::ofstream out(path, std::ios::binary);
    out << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
        << "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
    out.write(reinterpret_cast<const char*>(points.data()),
              std::streamsize(points.size() * sizeof(points[0])));
    return bool(out.flush());
}

}  // namespace peers
