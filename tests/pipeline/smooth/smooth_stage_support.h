#pragma once

#include "formats/model_file.h"
#include "pipeline/smooth/smooth_stage.h"
#include "slim/base/hash.h"
#include "slim/shapes/foot_point.h"
#include "tests/pipeline/build/fit_stages_support.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace slim::test {

inline double rms_distance(const char* shape, const std::vector<Vec3d>& points) {
    double sum = 0;
    for (const Vec3d& p : points) sum += std::pow(signed_distance(find_shape(shape), p), 2);
    return std::sqrt(sum / static_cast<double>(points.size()));
}

class SmoothStage : public FitStages {
protected:
    nlohmann::json smooth(const std::string& cloud, SmoothConfig c = {}) {
        c.model = file("m.slim");
        c.cloud = cloud;
        if (c.output.empty()) c.output = file("smooth.ply");
        return run_as("smooth", c, run_smooth, listener_);
    }
    std::string noisy(const char* shape, double noise, bool normals = true) {
        const std::string cloud = write(sampled(shape, 20000, 1, noise), "noisy.ply", normals);
        build(build_config(cloud, "m.slim"));
        return cloud;
    }
    /// The sides of a cube of edge 1, 24 squares along it; their corners that meet stand there
    /// once. Noise per coordinate.
    std::string cube(double noise) {
        const int n = 24;
        std::map<std::array<int, 3>, int> number;
        std::string vertices, faces;
        const auto vertex = [&](const std::array<int, 3>& at) {
            const auto [found, is_new] = number.try_emplace(at, static_cast<int>(number.size()));
            if (is_new)
                for (std::size_t k = 0; k < 3; ++k) {
                    const auto key = static_cast<std::uint64_t>(3 * number.size() + k);
                    vertices +=
                        std::to_string(at[k] / double(n) +
                                       noise * 3.46 * (unit_interval(keyed_hash(2, key)) - 0.5)) +
                        (k < 2 ? " " : "\n");
                }
            return std::to_string(found->second);
        };
        int n_faces = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const int side : {0, n})
                for (int i = 0; i < n; ++i)
                    for (int k = 0; k < n; ++k, ++n_faces) {
                        const auto corner = [&](int u, int v) {
                            std::array<int, 3> at{};
                            at[axis] = side, at[(axis + 1) % 3] = i + u, at[(axis + 2) % 3] = k + v;
                            return " " + vertex(at);
                        };
                        faces +=
                            side > 0
                                ? "4" + corner(0, 0) + corner(1, 0) + corner(1, 1) + corner(0, 1)
                                : "4" + corner(0, 0) + corner(0, 1) + corner(1, 1) + corner(1, 0);
                        faces += "\n";
                    }
        return folder_.write(
            "cube.ply",
            "ply\nformat ascii 1.0\nelement vertex " + std::to_string(number.size()) +
                "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                std::to_string(n_faces) + "\nproperty list uchar int vertex_indices\nend_header\n" +
                vertices + faces);
    }
    /// A sphere of n by 2 n quadrangles around a pole, noisy; open: without its lower half.
    std::string mesh(double noise, bool open = false) {
        const int n = 40, rows = open ? n / 2 : n;
        std::string vertices, faces;
        int n_vertices = 0, n_faces = 0;
        for (int i = 0; i <= rows; ++i)
            for (int k = 0; k < 2 * n; ++k, ++n_vertices) {
                const double a = (0.5 + i) * M_PI / (n + 1), b = k * M_PI / n;
                const auto key = static_cast<std::uint64_t>(n_vertices);
                const double r = 1 + noise * 2 * (unit_interval(keyed_hash(1, key)) - 0.5);
                for (const double x :
                     {std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)})
                    vertices += std::to_string(r * x) + " ";
                vertices += std::to_string(n_vertices % 7) + "\n";
            }
        for (int i = 0; i < rows; ++i)
            for (int k = 0; k < 2 * n; ++k, ++n_faces) {
                const int l = (k + 1) % (2 * n), a = 2 * n * i, b = a + 2 * n;
                faces += "4";
                for (const int v : {a + k, b + k, b + l, a + l}) faces += " " + std::to_string(v);
                faces += "\n";
            }
        return folder_.write(
            "mesh.ply", "ply\nformat ascii 1.0\nelement vertex " + std::to_string(n_vertices) +
                            "\nproperty double x\nproperty double y\nproperty double z\nproperty "
                            "uchar tag\nelement face " +
                            std::to_string(n_faces) +
                            "\nproperty list uchar int vertex_indices\nend_header\n" + vertices +
                            faces);
    }
};

}  // namespace slim::test
