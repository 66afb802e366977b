#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <holdfast/program/picture.hpp>
#include <limits>

namespace holdfast::program {

using common::Drawing;

namespace {

constexpr std::array kColours{"#0072b2", "#e69f00", "#009e73",
                              "#cc79a7", "#56b4e9", "#8a6d3b"};  // Okabe and Ito, without the red of outliers
constexpr double kWidth = 1000;                                  // of the picture

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '&')
      safe += "&amp;";
    else if (c == '"')
      safe += "&quot;";
    else
      safe += c;
  }
  return safe;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// Metres to the picture's units, y upwards.
class Frame {
 public:
  explicit Frame(const Drawing& drawing) {
    const auto take = [this](const Drawing::Place& p) {
      for (int axis = 0; axis < 2; ++axis) {
        if (!std::isfinite(p[axis])) continue;
        low_[axis] = std::min(low_[axis], p[axis]);
        high_[axis] = std::max(high_[axis], p[axis]);
      }
    };
    for (const Drawing::Track& track : drawing.tracks) {
      for (const Drawing::Place& p : track.estimate) take(p);
      for (const Drawing::Place& p : track.truth) take(p);
    }
    if (low_[0] > high_[0] || low_[1] > high_[1]) low_ = {0, 0}, high_ = {1, 1};
    for (int axis = 0; axis < 2; ++axis) {
      const double margin = 0.04 * std::max({high_[0] - low_[0], high_[1] - low_[1], 1e-3});
      low_[axis] -= margin, high_[axis] += margin;
    }
    scale_ = kWidth / (high_[0] - low_[0]);
  }
  double height() const { return scale_ * (high_[1] - low_[1]); }
  std::string at(const Drawing::Place& p) const { return number(scale_ * (p[0] - low_[0])) + "," + number(scale_ * (high_[1] - p[1])); }
  double scale() const { return scale_; }

 private:
  std::array<double, 2> low_{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::array<double, 2> high_{-low_[0], -low_[1]};
  double scale_;
};

std::string path_of(const std::vector<Drawing::Place>& places, const Frame& frame) {
  std::string d;
  for (const Drawing::Place& p : places) d += (d.empty() ? "M" : " L") + frame.at(p);
  return d;
}
std::string path_of(const std::vector<Drawing::Line>& lines, const Frame& frame) {
  std::string d;
  for (const Drawing::Line& line : lines) d += "M" + frame.at(line.from) + "L" + frame.at(line.to);
  return d;
}

std::string marks(const std::vector<Drawing::Place>& places, const Frame& frame, const std::string& shape) {
  std::string marks;
  for (const Drawing::Place& p : places) marks += "<use href='#" + shape + "' transform='translate(" + frame.at(p) + ")'/>";
  return marks;
}

/// Three sigmas.
std::string path_of(const Drawing::Ellipse& one, const Frame& frame) {
  Eigen::Matrix2d covariance;
  covariance << one.xx, one.xy, one.xy, one.yy;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance);
  std::string d;
  constexpr int kCorners = 36;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * M_PI * i / kCorners;
    const Eigen::Vector2d sigmas = 3 * axes.eigenvalues().cwiseMax(0).cwiseSqrt();
    const Eigen::Vector2d p = axes.eigenvectors() * sigmas.cwiseProduct(Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    d += (d.empty() ? "M" : "L") + frame.at({one.centre[0] + p[0], one.centre[1] + p[1]});
  }
  return d + "Z";
}

/// A length of 1, 2 or 5 times a power of ten that takes up to a quarter of the width.
double scale_bar(const Frame& frame) {
  const double longest = 0.25 * kWidth / frame.scale(), power = std::pow(10, std::floor(std::log10(longest)));
  for (const double step : {5.0, 2.0})
    if (step * power <= longest) return step * power;
  return power;
}

/// A name, in the id of a layer, and what is drawn.
struct Layer {
  std::string id, label, content;
};

std::vector<Layer> layers_of(const Drawing& drawing, const Frame& frame) {
  std::vector<Layer> layers;
  const auto add = [&](const char* id, const std::string& label, const std::string& content) {
    if (!content.empty()) layers.push_back({id, label, content});
  };
  add("kept", "measurements kept (" + std::to_string(drawing.kept.size()) + " drawn)",
      drawing.kept.empty() ? "" : "<path class=kept d='" + path_of(drawing.kept, frame) + "'/>");
  add("rejected", "outliers (" + std::to_string(drawing.rejected.size()) + ")",
      drawing.rejected.empty() ? "" : "<path class=rejected d='" + path_of(drawing.rejected, frame) + "'/>");
  std::string truth, estimate;
  for (std::size_t i = 0; i < drawing.tracks.size(); ++i) {
    const Drawing::Track& track = drawing.tracks[i];
    const std::string colour = kColours[i % kColours.size()], title = "<title>" + escaped(track.name) + "</title>";
    if (track.is_way) {
      estimate += "<path class=way stroke='" + colour + "' d='" + path_of(track.estimate, frame) + "'>" + title + "</path>";
      if (!track.truth.empty()) truth += "<path class=truth d='" + path_of(track.truth, frame) + "'>" + title + "</path>";
    } else {
      estimate += "<g fill='" + colour + "'>" + title + marks(track.estimate, frame, "estimated") + "</g>";
      if (!track.truth.empty()) truth += "<g>" + title + marks(track.truth, frame, "true") + "</g>";
    }
  }
  add("truth", "truth", truth);
  add("estimate", "estimate", estimate);
  std::string ellipses;
  for (const Drawing::Ellipse& one : drawing.ellipses) ellipses += path_of(one, frame);
  add("ellipses", "3σ", ellipses.empty() ? "" : "<path class=ellipse d='" + ellipses + "'/>");
  return layers;
}

const char* const kStyle =
    ":root{color-scheme:light dark;--ink:#1b1b1b;--paper:#fff}@media(prefers-color-scheme:dark){:root{--ink:#ececec;--paper:#161616}}"
    "body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:70rem;margin:auto;padding:1rem}"
    "svg{width:100%;height:auto;max-height:85vh}label{margin-right:1.5rem;white-space:nowrap}path{fill:none;vector-effect:non-scaling-"
    "stroke}"
    ".kept{stroke:var(--ink);stroke-opacity:.08;stroke-width:1}.rejected{stroke:#d55e00;stroke-width:1.5;stroke-dasharray:6 3}"
    ".ellipse{stroke:var(--ink);stroke-width:1;fill:var(--ink);fill-opacity:.08}.way{stroke-width:2}.truth{stroke:var(--ink);stroke-width:"
    "1.2;stroke-dasharray:2 4}.bar{stroke:var(--ink);stroke-width:3}"
    "text{fill:var(--ink);font-size:20px}";

}  // namespace

std::string picture_page(const Drawing& drawing, const std::string& title, const std::string& caption) {
  const Frame frame(drawing);
  const std::vector<Layer> layers = layers_of(drawing, frame);
  const std::string name = escaped(title);
  std::string hide, boxes, groups;
  for (const Layer& layer : layers) {
    hide += "body:has(#show-" + layer.id + ":not(:checked)) #" + layer.id + "{display:none}";
    boxes += "<label><input type=checkbox id=show-" + layer.id + " checked> " + escaped(layer.label) + "</label>";
    groups += "<g id=" + layer.id + ">" + layer.content + "</g>";
  }
  std::string legend;
  for (std::size_t i = 0; i < drawing.tracks.size(); ++i)
    legend +=
        "<span><b style='color:" + std::string(kColours[i % kColours.size()]) + "'>■</b> " + escaped(drawing.tracks[i].name) + "</span> ";
  const double bar = scale_bar(frame), height = frame.height();
  const std::string bar_y = number(height - 15);
  return "<!doctype html><html lang=en><head><meta charset=utf-8><meta name=viewport content='width=device-width,initial-scale=1'>"
         "<link rel=icon href='data:,'><title>" +
         name + "</title><style>" + kStyle + hide + "</style></head><body><main><h1>" + name + "</h1><p>" + escaped(caption) +
         (drawing.tracks.empty() ? " Nothing here has a position." : "") + "</p><p>" + boxes + "</p><p>" + legend +
         "</p>\n<svg role=img aria-label='" + name + "' viewBox='0 0 " + number(kWidth) + " " + number(height) +
         "'><defs><circle id=estimated r=6 /><path id=true stroke='currentColor' stroke-width=2 d='M-7,-7L7,7M-7,7L7,-7'/></defs>" +
         groups + "<path class=bar d='M15," + bar_y + "h" + number(bar * frame.scale()) + "'/><text x=15 y=" + number(height - 22) + ">" +
         number(bar) + " m</text></svg></main></body></html>\n";
}

}  // namespace holdfast::program
