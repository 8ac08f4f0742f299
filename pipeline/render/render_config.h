#pragma once

#include <string>
#include <vector>

namespace slim {

/// Options of `slim render`.
struct RenderConfig {
    std::string model, output, job;
    std::string size = "1600x1200";
    std::string camera = "front";
    std::string name;
    double fov = 35;
    bool ortho = false;
    double ortho_width = 0;
    std::string up = "y";
    double zoom = 1;
    std::vector<std::string> aov{"shaded"};
    std::vector<std::string> lines;
    std::string lines_ply, lines_obj;
    std::string mode = "forward";
    std::string light = "key; fill shadows=off";
    double ambient = 1;
    std::string material;
    bool shadows = true;
    int bounces = 2;
    bool ao = false;
    double ao_distance = 0;
    int ao_samples = 36;
    bool ground = false;
    std::string ground_height = "auto";
    std::string ground_color = "shadow";
    std::vector<std::string> add;
    double lod = 4;
    bool loose = false;
    int repeat = 1;
    int supersample = 1;
    bool antialias = false;
    bool clean_outlines = false;
    std::vector<std::string> range, same_range;
    double percentile = 95;
    bool legend = true, legend_room = false;
    bool light_maps = false;
    std::string background = "auto";
    std::string format = "auto";
    std::string unit;
    std::string truth_shape;
    std::vector<double> offset;
    std::string environment, matcap;
    double environment_turn = 0;
    bool environment_behind = false;
    std::vector<double> sun{315, 45};
    std::string contours = "auto";
    bool scale_bar = false, same_scale = false;
    std::string crop, tile;
    int turntable = 0, frames = 0, frame = 0;
    std::string path;
    std::string share;
    int join = 0;

    template <class Visitor>
    void visit(Visitor&& field) {
        visit_camera(field);
        visit_drawn(field);
        visit_light(field);
        visit_frame(field);
        visit_maps(field);
        visit_looks(field);
        visit_parts(field);
    }

private:
    // The model, the files, the size and the camera.
    template <class Visitor>
    void visit_camera(Visitor& field) {
        field.input("model", model, "model to draw (model.slim)");
        field.output(
            "output", output,
            "x.png, x.exr (with x.png as its preview), or a folder (<view>.<aov>.png in it)");
        field.path("job", job,
                   "draws the views of a job file (or ready style) of this model, with its "
                   "[render], lights and materials, into the folder, or the file if there is one "
                   "view; other options win over the job's, for every view, and so do the keys of "
                   "a --config, of a printed one, which names most keys, those not as by default");
        field("size", size, "picture in pixels, WIDTHxHEIGHT");
        field("camera", camera,
              "front, back, left, right, top, bottom, iso, or nine numbers "
              "ex,ey,ez,tx,ty,tz,ux,uy,uz (world; six: "
              "up is --up)");
        field("name", name, "name of the view in file names (default: the camera's)");
        field(
            "fov", fov,
            "angle of view from top to bottom, degrees (a named camera frames what is drawn at any "
            "angle: --zoom enlarges)",
            0.001, 179);
        field("ortho", ortho, "orthographic instead of perspective");
        field("ortho_width", ortho_width, "orthographic, this wide in model units (0: as --ortho)",
              0, 1e30);
        field.choice("up", up, "axis that named cameras hold upright",
                     {"y", "z", "x", "-y", "-z", "-x"});
        field("zoom", zoom,
              "enlarges about the picture's middle, of named cameras that of what they frame: 2 "
              "shows half of what the camera shows",
              0.001, 1000);
    }

    // What is drawn, and how it is found.
    template <class Visitor>
    void visit_drawn(Visitor& field) {
        field.choice("aov", aov, "what to draw; several make several pictures",
                     {"shaded",   "color", "environment", "matcap",  "reflection", "hillshade",
                      "mean",     "gauss", "k1",          "k2",      "dir1",       "dir2",
                      "e1",       "e2",    "dk1_dt2",     "dk2_dt1", "normal",     "depth",
                      "position", "id",    "error",       "level",   "coverage",   "ao",
                      "truth_distance",    "lines",       "all"});
        field.choice("lines", lines,
                     "feature lines, drawn over the pictures (alone on white: --aov lines) and "
                     "beside them as x.lines.svg; crest needs a model of --degree 3, crease one of "
                     "--sharp on; with contour, too, creases along outlines are contours",
                     {"contour", "suggestive", "crest", "crease", "parabolic", "reflection"});
        field.path("lines_ply", lines_ply, "the lines in space as PLY (vertex and edge elements)");
        field.path("lines_obj", lines_obj, "the lines in space as OBJ");
        field.choice(
            "mode", mode,
            "forward: fast; raytrace: shadows, mirrors, ambient occlusion; brute: the slow "
            "reference in doubles",
            {"forward", "raytrace", "brute"});
    }

    // Light, materials and what rays add.
    template <class Visitor>
    void visit_light(Visitor& field) {
        field("light", light,
              "lights, 'KIND key=value ...; KIND ...': key, fill, sun azimuth= elevation= (or "
              "from=x,y,z), point at=x,y,z, spot at= to= cone= blur=, rect at= to= size=W,H, disc "
              "at= to= size=; all take power= color=#rrggbb shadows=on|off; angle= (sun, key, "
              "fill) and size= (rect, disc) make soft shadows of samples= rays; blur= is the share "
              "of a spot's cone over which its edge fades (0: hard, 1: from the middle); power 1 "
              "is as bright as the key light at to=, or else at the middle of the model, but no "
              "nearer than half the shortest side of its box, so that a lamp in a room lights it");
        field("ambient", ambient, "strength of the light that comes from everywhere", 0, 100);
        field(
            "material", material,
            "of each model, 'color=#rrggbb specular= shininess= mirror=; ...' (mirror: raytrace); "
            "color=scan: the scan's own colours, of a model built with --color");
        field("shadows", shadows, "raytrace: lights throw shadows");
        field("bounces", bounces, "raytrace: mirror images within mirror images", 0, 16);
        field("ao", ao, "raytrace: ambient occlusion dims the ambient light (alone: --aov ao)");
        field("ao_distance", ao_distance,
              "how near a surface shuts out ambient light, model units (0: a quarter of the "
              "diagonal)",
              0, 1e30);
        field("ao_samples", ao_samples, "rays per pixel for it, rounded up to a square", 1, 4096);
        field("ground", ground,
              "raytrace: a plane under the model, across --up, that takes shadows");
        field("ground_height", ground_height,
              "where it cuts the up axis, world (auto: under what is drawn)");
        field(
            "ground_color", ground_color,
            "#rrggbb: opaque, to light from below, too; or shadow: only its shadows are seen, over "
            "the background");
        field.path("add", add,
                   "raytrace: further models of the scene, --add a.slim,b.slim or --add again");
    }

    // How finely.
    template <class Visitor>
    void visit_frame(Visitor& field) {
        field("lod", lod,
              "draw a ball's stand-in when smaller than this in pixels, or what it shows is (0: "
              "never; forward only)",
              0, 1e6);
        field("loose", loose,
              "draw loose surfels too: small pieces that agree with no surface about them");
        field("repeat", repeat, "draw this often and report the median time", 1, 10000);
        field("supersample", supersample, "pictures at twice the size, averaged", 1, 2);
        field("antialias", antialias,
              "pictures: pixels at edges, and where the colour changes as much, are drawn as with "
              "--supersample 2");
        field("clean_outlines", clean_outlines,
              "what single surfels show past a silhouette, as flaps and crumbs, is left out");
    }

    // Ranges and legends of the maps.
    template <class Visitor>
    void visit_maps(Visitor& field) {
        field("range", range,
              "fixed ranges of maps: A for [-A, A] (unsigned: [0, A]), AOV=A or AOV=LO:HI (signed "
              "maps keep 0 neutral: each side goes to its own end)");
        field("same_range", same_range,
              "named cameras whose automatic ranges, the largest of each map, are the range of its "
              "maps: "
              "pictures from several sides then compare");
        field("percentile", percentile,
              "share of |values| that an automatic range holds (of curvatures where most pixels "
              "are flat, with radii above 10 diagonals: of the others)",
              1, 100);
        field("legend", legend,
              "legend bar in the maps and beside them as SVG; where a picture of the run has one, "
              "named cameras leave its room free in all of them, so that they overlay: a corner "
              "that is free anyway, or a strip at the right or below, whichever leaves the model "
              "larger (--no-legend: the model fills them); over a view that --zoom fills, where it "
              "hides the least");
        field("legend_room", legend_room,
              "named cameras leave the room of the largest legend, whatever the run's pictures "
              "have, so that those of several runs overlay (not where --zoom fills it)");
        field("light_maps", light_maps,
              "light the curvature maps and the scan's colours (which are then not exact)");
    }

    // Backgrounds, files and the looks of single maps.
    template <class Visitor>
    void visit_looks(Visitor& field) {
        field("background", background,
              "auto, white, black, gradient, transparent, #rrggbb or #top,#bottom; lines alone are "
              "light on dark ones, in the SVG too");
        field.choice("format", format, "auto: by the output's extension, PNG in a folder",
                     {"auto", "png", "exr"});
        field("unit", unit, "name of the model's length unit, for legends (mm, m, ...)");
        field("truth_shape", truth_shape, "analytic shape that truth_distance measures against");
        field("offset", offset, "where that shape's origin lies in the world: x,y,z");
        field.path("environment", environment,
                   "lat-long picture of the light for --aov environment: EXR, HDR, PNG, ... "
                   "(default: a built-in "
                   "studio)");
        field("environment_turn", environment_turn, "turns it about the up axis, degrees", -360,
              360);
        field("environment_behind", environment_behind, "shows it behind the model");
        field.path(
            "matcap", matcap,
            "picture of a ball for --aov matcap: PNG, JPEG, EXR, ... (default: a built-in one)");
        field("sun", sun,
              "of --aov hillshade: azimuth clockwise from north (+y, with --up z), altitude; "
              "degrees");
        field("contours", contours,
              "contour lines of --aov hillshade: auto, none, or their spacing in model units "
              "(every fifth is heavier and has its height above the world's 0, where it has room; "
              "beside the picture as x.contours.svg; films have lines alone)");
        field("scale_bar", scale_bar, "scale bar and size of a pixel, in orthographic pictures");
        field("same_scale", same_scale,
              "orthographic named cameras: one scale for all six sides, at which each fits");
    }

    // Parts of a picture, and films.
    template <class Visitor>
    void visit_parts(Visitor& field) {
        field("crop", crop,
              "draws only x,y,w,h of the picture (pixels, from the top left): the bytes that the "
              "whole has there (with lines each part, of --tile and --share too, first finds those "
              "of the whole picture: 16 parts took four times the whole)");
        field("turntable", turntable,
              "pictures of a full turn about the up axis, numbered x_0001.png, ...", 0, 9999);
        field("path", path,
              "camera path for --frames: keyframes between ';', each as --camera, 'zoom Z' after "
              "it if wanted");
        field("frames", frames, "pictures along --path, from its first keyframe to its last", 0,
              9999);
        field("frame", frame, "draws only this picture of a turntable or path, from 1 (0: all)", 0,
              9999);
        field(
            "tile", tile,
            "i/n: draws only part i (1 to n) of n bands of rows, for array jobs");
        field.part(
            "share", share,
            "i/n: draws share i of a film (pictures in a row) or picture (rows) that n tasks draw; "
            "then --join n");
        field.part("join", join,
                   "checks that all of so many shares are there and makes the whole of them: the "
                   "bytes of one run",
                   0, 9999);
    }
};

}  // namespace slim
