#pragma once

#include "formats/image_io.h"
#include "formats/model_file.h"
#include "pipeline/render/render_stage.h"
#include "slim/base/error.h"
#include "tests/raytrace/support/analytic_models.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

namespace slim::test {

/// Four bytes.
inline const std::uint8_t* pixel(const PngImage& image, int x, int y) {
    return &image.rgba[4 * static_cast<std::size_t>(y * image.width + x)];
}

/// Pixels beside what a picture shows.
struct Margins {
    int left, right, top, bottom;
    int least() const { return std::min({left, right, top, bottom}); }
};

inline Margins margins(const PngImage& image) {
    Margins m{image.width, image.width, image.height, image.height};
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            if (pixel(image, x, y)[3] == 0) continue;
            m.left = std::min(m.left, x), m.right = std::min(m.right, image.width - 1 - x);
            m.top = std::min(m.top, y), m.bottom = std::min(m.bottom, image.height - 1 - y);
        }
    return m;
}

/// A folder with a sphere model in it, and runs of the render stage there at small sizes.
class RenderTest : public testing::Test {
protected:
    RenderTest() {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() /
                  ("slim_render_" + std::string(info->name()) + "_" + std::to_string(getpid()));
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        write_model(file("m.slim"), sphere_model(1, 600), "{}");
    }
    ~RenderTest() override { std::filesystem::remove_all(folder_); }

    std::string file(const std::string& name) const { return (folder_ / name).string(); }

    RenderConfig config(const std::string& output) const {
        RenderConfig c;
        c.model = file("m.slim");
        c.output = file(output);
        c.size = "80x60";
        return c;
    }

    nlohmann::json run(RenderConfig c, bool force = false) { return run(c, force, reporter_); }
    nlohmann::json run(RenderConfig c, bool force, Reporter& reporter) {
        const FieldList fields = fields_of(c);
        StageContext context{reporter,        1,  force, "render", canonical_config(fields),
                             print_config(fields), ""};
        return run_render(c, context);
    }

    PngImage draw(const RenderConfig& c) {
        run(c);
        return read_png(c.output);
    }

    /// Of an option: the picture before, and what the option changes of it.
    struct OptionCase {
        const char* what;
        std::function<void(RenderConfig&)> before, change;
    };
    /// A picture that ignores its option fails.
    template <class Cases>
    void expect_each_changes(const RenderConfig& usual, const Cases& cases) {
        for (const OptionCase& each : cases) {
            RenderConfig c = usual;
            each.before(c);
            const auto before = draw(c).rgba;
            c.output = file("after.png");
            each.change(c);
            EXPECT_NE(before, draw(c).rgba) << each.what;
        }
    }

    /// Of an option that does not go: a word of the message.
    struct RefusedCase {
        const char* word;
        std::function<void(RenderConfig&)> change;
    };
    /// Each is a ConfigError that has its word.
    template <class Cases>
    void expect_each_is_refused(const RenderConfig& usual, const Cases& cases) {
        for (const RefusedCase& each : cases) {
            RenderConfig c = usual;
            each.change(c);
            try {
                run(c);
                ADD_FAILURE() << each.word;
            } catch (const ConfigError& e) {
                EXPECT_NE(std::string(e.what()).find(each.word), std::string::npos) << e.what();
            }
        }
    }

    bool exists(const std::string& name) const {
        return std::filesystem::exists(folder_ / name);
    }
    std::string bytes(const std::string& name) const {
        std::ifstream in(folder_ / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }

    std::filesystem::path folder_;
    Reporter reporter_;
};

}  // namespace slim::test
