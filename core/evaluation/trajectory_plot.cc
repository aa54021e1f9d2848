#include "core/evaluation/trajectory_plot.h"

#include <cairo.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <vector>

#include "core/error.h"
#include "core/geometry/angles.h"
#include "core/io/atomic_file.h"

namespace arborslam {
namespace {

// Layout [px].
constexpr double kWidth = 1000.0;
constexpr double kMarginLeft = 92.0;
constexpr double kMarginRight = 30.0;
constexpr double kHeaderHeight = 92.0;
constexpr double kAxisLabelHeight = 56.0;
constexpr double kMinMapHeight = 260.0;
constexpr double kMaxMapHeight = 760.0;
constexpr double kErrorHeight = 180.0;
constexpr double kFooterHeight = 12.0;
constexpr double kTickSpacing = 85.0;

constexpr double kTitleSize = 17.0;
constexpr double kTextSize = 13.0;
constexpr double kTickSize = 12.0;

struct Color {
  double red, green, blue;
};
constexpr Color kTextColor{0.15, 0.15, 0.17};
constexpr Color kMutedColor{0.40, 0.40, 0.43};
constexpr Color kGridColor{0.90, 0.90, 0.91};
constexpr Color kFrameColor{0.62, 0.62, 0.65};
constexpr Color kReferenceColor{0.25, 0.27, 0.30};
constexpr Color kEstimateColor{0.84, 0.33, 0.08};

struct Range {
  double low, high;
  double size() const { return high - low; }
};

/// A rectangle of the image and the part of the world that it shows.
struct Panel {
  double left, top, width, height;
  Range x, y;

  double PixelX(double value) const { return left + (value - x.low) / x.size() * width; }
  double PixelY(double value) const { return top + height - (value - y.low) / y.size() * height; }
};

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

void SetColor(cairo_t* cr, const Color& color, double opacity = 1.0) {
  cairo_set_source_rgba(cr, color.red, color.green, color.blue, opacity);
}

enum class Anchor { kLeft, kCentre, kRight };

double TextWidth(cairo_t* cr, const std::string& text) {
  cairo_text_extents_t extents;
  cairo_text_extents(cr, text.c_str(), &extents);
  return extents.x_advance;
}

void DrawText(cairo_t* cr, const std::string& text, double x, double y, Anchor anchor) {
  const double width = TextWidth(cr, text);
  const double shift = anchor == Anchor::kLeft ? 0.0 : anchor == Anchor::kCentre ? 0.5 * width : width;
  cairo_move_to(cr, x - shift, y);
  cairo_show_text(cr, text.c_str());
}

void SetFont(cairo_t* cr, double size, bool is_bold = false) {
  cairo_select_font_face(cr, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         is_bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cr, size);
}

std::string Format(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

// `text` without the bytes that are not printable ASCII (a file name can hold anything, cairo stops at bad UTF-8),
// shortened at the front to `width`.
std::string Fitted(cairo_t* cr, const std::string& text, double width) {
  std::string fitted;
  for (const char character : text) fitted += character >= ' ' && character <= '~' ? character : '?';
  if (TextWidth(cr, fitted) <= width) return fitted;
  while (!fitted.empty() && TextWidth(cr, "..." + fitted) > width) fitted.erase(0, 1);
  return "..." + fitted;
}

// The distance of ticks, 1, 2 or 5 times a power of ten, that gives at most `max_ticks` of them over `size`.
double TickStep(double size, double max_ticks) {
  const double least = size / std::max(1.0, max_ticks);
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least) return factor * power;
  }
  return 10.0 * power;
}

std::vector<double> Ticks(const Range& range, double step) {
  const double first = std::ceil(range.low / step - 1e-9);
  const double last = std::floor(range.high / step + 1e-9);
  std::vector<double> ticks;
  for (double i = first; i <= last && ticks.size() < 100; i += 1.0) ticks.push_back(i * step);
  return ticks;
}

std::string TickLabel(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  char text[64];
  // Adding 0 turns -0 into 0.
  std::snprintf(text, sizeof(text), "%.*f", decimals, std::abs(value) < 1e-9 * step ? 0.0 : value + 0.0);
  return text;
}

void DrawAxes(cairo_t* cr, const Panel& panel, double x_step, double y_step, const std::string& x_label,
              const std::string& y_label) {
  SetFont(cr, kTickSize);
  cairo_set_line_width(cr, 1.0);
  const double bottom = panel.top + panel.height;
  for (const double value : Ticks(panel.x, x_step)) {
    const double x = std::round(panel.PixelX(value)) + 0.5;
    SetColor(cr, kGridColor);
    cairo_move_to(cr, x, panel.top);
    cairo_line_to(cr, x, bottom);
    cairo_stroke(cr);
    SetColor(cr, kMutedColor);
    DrawText(cr, TickLabel(value, x_step), x, bottom + 18.0, Anchor::kCentre);
  }
  for (const double value : Ticks(panel.y, y_step)) {
    const double y = std::round(panel.PixelY(value)) + 0.5;
    SetColor(cr, kGridColor);
    cairo_move_to(cr, panel.left, y);
    cairo_line_to(cr, panel.left + panel.width, y);
    cairo_stroke(cr);
    SetColor(cr, kMutedColor);
    DrawText(cr, TickLabel(value, y_step), panel.left - 8.0, y + 4.5, Anchor::kRight);
  }
  SetColor(cr, kFrameColor);
  cairo_rectangle(cr, std::round(panel.left) + 0.5, std::round(panel.top) + 0.5, std::round(panel.width),
                  std::round(panel.height));
  cairo_stroke(cr);
  SetColor(cr, kTextColor);
  SetFont(cr, kTextSize);
  DrawText(cr, x_label, panel.left + 0.5 * panel.width, bottom + 39.0, Anchor::kCentre);
  cairo_save(cr);
  cairo_translate(cr, 22.0, panel.top + 0.5 * panel.height);
  cairo_rotate(cr, -0.5 * kPi);
  DrawText(cr, y_label, 0.0, 0.0, Anchor::kCentre);
  cairo_restore(cr);
}

using Position = std::function<const Eigen::Vector3d&(const PosePair&)>;

void DrawPath(cairo_t* cr, const Panel& panel, const std::vector<PosePair>& pairs, const Position& position,
              const Color& color, double line_width) {
  SetColor(cr, color);
  cairo_set_line_width(cr, line_width);
  // Beginning with a line to itself, a single point becomes a dot by its round caps.
  const Eigen::Vector3d& first = position(pairs.front());
  cairo_move_to(cr, panel.PixelX(first.x()), panel.PixelY(first.y()));
  for (const PosePair& pair : pairs) {
    cairo_line_to(cr, panel.PixelX(position(pair).x()), panel.PixelY(position(pair).y()));
  }
  cairo_stroke(cr);
}

Range Padded(double low, double high, double fraction) {
  // Below a millimetre there is nothing to see: show a metre.
  const double padding = high - low < 1e-3 ? 0.5 : fraction * (high - low);
  return {low - padding, high + padding};
}

// The range about the same middle with the given size.
Range Widened(const Range& range, double size) {
  const double middle = 0.5 * (range.low + range.high);
  return {middle - 0.5 * size, middle + 0.5 * size};
}

Panel MapPanel(const std::vector<PosePair>& pairs) {
  Eigen::AlignedBox2d box;
  for (const PosePair& pair : pairs) {
    box.extend(pair.estimate.position.head<2>());
    box.extend(pair.reference.position.head<2>());
  }
  Panel panel{};
  panel.left = kMarginLeft;
  panel.top = kHeaderHeight;
  panel.width = kWidth - kMarginLeft - kMarginRight;
  panel.x = Padded(box.min().x(), box.max().x(), 0.05);
  panel.y = Padded(box.min().y(), box.max().y(), 0.05);
  panel.height = std::clamp(std::round(panel.width * panel.y.size() / panel.x.size()), kMinMapHeight, kMaxMapHeight);
  const double metres_per_pixel = std::max(panel.x.size() / panel.width, panel.y.size() / panel.height);
  panel.x = Widened(panel.x, metres_per_pixel * panel.width);
  panel.y = Widened(panel.y, metres_per_pixel * panel.height);
  return panel;
}

void DrawStart(cairo_t* cr, double x, double y) {
  cairo_new_path(cr);  // Or the arc would be joined to the end of the text drawn last.
  cairo_arc(cr, x, y, 5.0, 0.0, 2.0 * kPi);
  cairo_set_source_rgb(cr, 1.0, 1.0, 1.0);
  cairo_fill_preserve(cr);
  SetColor(cr, kReferenceColor);
  cairo_set_line_width(cr, 2.0);
  cairo_stroke(cr);
}

void DrawEnd(cairo_t* cr, double x, double y) {
  cairo_rectangle(cr, x - 4.5, y - 4.5, 9.0, 9.0);
  SetColor(cr, kReferenceColor);
  cairo_fill(cr);
}

void DrawMap(cairo_t* cr, const Panel& panel, const std::vector<PosePair>& pairs) {
  const double step = TickStep(panel.x.size(), panel.width / kTickSpacing);
  DrawAxes(cr, panel, step, step, "x [m]", "y [m]");
  DrawPath(
      cr, panel, pairs, [](const PosePair& p) -> const Eigen::Vector3d& { return p.reference.position; },
      kReferenceColor, 3.0);
  DrawPath(
      cr, panel, pairs, [](const PosePair& p) -> const Eigen::Vector3d& { return p.estimate.position; }, kEstimateColor,
      1.5);
  const Eigen::Vector3d& start = pairs.front().reference.position;
  const Eigen::Vector3d& end = pairs.back().reference.position;
  DrawEnd(cr, panel.PixelX(end.x()), panel.PixelY(end.y()));
  DrawStart(cr, panel.PixelX(start.x()), panel.PixelY(start.y()));
}

void DrawErrors(cairo_t* cr, const Panel& panel, const TrajectoryEvaluation& evaluation) {
  DrawAxes(cr, panel, TickStep(panel.x.size(), panel.width / kTickSpacing), TickStep(panel.y.size(), 5.0),
           "distance along the reference [m]", "error [m]");
  const double bottom = panel.top + panel.height;
  cairo_move_to(cr, panel.PixelX(0.0), bottom);
  for (size_t i = 0; i < evaluation.path.size(); ++i) {
    cairo_line_to(cr, panel.PixelX(evaluation.path[i]), panel.PixelY(evaluation.position_errors[i]));
  }
  cairo_line_to(cr, panel.PixelX(evaluation.path_length()), bottom);
  SetColor(cr, kEstimateColor, 0.15);
  cairo_fill(cr);
  SetColor(cr, kEstimateColor);
  cairo_set_line_width(cr, 1.3);
  for (size_t i = 0; i < evaluation.path.size(); ++i) {
    cairo_line_to(cr, panel.PixelX(evaluation.path[i]), panel.PixelY(evaluation.position_errors[i]));
  }
  cairo_stroke(cr);

  const double rms = evaluation.metrics.position_rms;
  const double y = panel.PixelY(rms);
  const double dashes[] = {6.0, 4.0};
  SetColor(cr, kReferenceColor);
  cairo_set_dash(cr, dashes, 2, 0.0);
  cairo_set_line_width(cr, 1.2);
  cairo_move_to(cr, panel.left, y);
  cairo_line_to(cr, panel.left + panel.width, y);
  cairo_stroke(cr);
  cairo_set_dash(cr, nullptr, 0, 0.0);
}

std::string Describe(AlignmentKind kind) {
  switch (kind) {
    case AlignmentKind::kNone:
      return "not aligned";
    case AlignmentKind::kOrigin:
      return "first poses aligned";
    case AlignmentKind::kSe2:
      return "SE(2) aligned";
    case AlignmentKind::kSe3:
      return "SE(3) aligned";
  }
  return "";
}

void DrawHeader(cairo_t* cr, const TrajectoryEvaluation& evaluation, const TrajectoryPlotLabels& labels) {
  SetColor(cr, kTextColor);
  SetFont(cr, kTitleSize, true);
  const std::string figure = "ATE " + Format("%.3f m", evaluation.metrics.ate_rmse) + " RMSE, SE(2) aligned";
  const double right = kWidth - kMarginRight;
  DrawText(cr, figure, right, 34.0, Anchor::kRight);
  DrawText(cr, Fitted(cr, labels.title, right - kMarginLeft - TextWidth(cr, figure) - 30.0), kMarginLeft, 34.0,
           Anchor::kLeft);

  // The legend, above the map so that it hides nothing.
  SetFont(cr, kTextSize);
  double x = kMarginLeft;
  const double y = 68.0;
  const auto draw_entry = [&](const std::string& text, const std::function<void()>& draw_symbol) {
    draw_symbol();
    SetColor(cr, kTextColor);
    DrawText(cr, text, x + 34.0, y + 4.5, Anchor::kLeft);
    x += 34.0 + TextWidth(cr, text) + 26.0;
  };
  const auto draw_line = [&](const Color& color, double line_width) {
    SetColor(cr, color);
    cairo_set_line_width(cr, line_width);
    cairo_move_to(cr, x + 2.0, y);
    cairo_line_to(cr, x + 26.0, y);
    cairo_stroke(cr);
  };
  draw_entry("reference", [&] { draw_line(kReferenceColor, 3.0); });
  draw_entry("estimate, " + Describe(evaluation.alignment), [&] { draw_line(kEstimateColor, 1.8); });
  draw_entry("start", [&] { DrawStart(cr, x + 22.0, y); });
  draw_entry("end", [&] { DrawEnd(cr, x + 22.0, y); });
  draw_entry("RMS of the error as drawn, " + Format("%.3f m", evaluation.metrics.position_rms), [&] {
    const double dashes[] = {6.0, 4.0};
    cairo_set_dash(cr, dashes, 2, 0.0);
    draw_line(kReferenceColor, 1.2);
    cairo_set_dash(cr, nullptr, 0, 0.0);
  });
}

cairo_status_t AppendBytes(void* bytes, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

void CheckStatus(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS) {
    throw UserError("plot", std::string("cannot be drawn: ") + cairo_status_to_string(status), "free some memory");
  }
}

}  // namespace

std::string RenderTrajectoryPlot(const TrajectoryEvaluation& evaluation, const TrajectoryPlotLabels& labels) {
  const Panel map = MapPanel(evaluation.aligned_pairs);
  Panel errors{};
  errors.left = map.left;
  errors.width = map.width;
  errors.top = map.top + map.height + kAxisLabelHeight;
  errors.height = kErrorHeight;
  errors.x = {0.0, evaluation.path_length() > 0.0 ? evaluation.path_length() : 1.0};
  const double largest = *std::max_element(evaluation.position_errors.begin(), evaluation.position_errors.end());
  errors.y = {0.0, std::max(1.1 * largest, 1e-3)};

  const double height = errors.top + errors.height + kAxisLabelHeight + kFooterHeight;
  const Surface surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(kWidth), static_cast<int>(std::lround(height))),
      &cairo_surface_destroy);
  const Context context(cairo_create(surface.get()), &cairo_destroy);
  cairo_t* cr = context.get();
  cairo_set_source_rgb(cr, 1.0, 1.0, 1.0);
  cairo_paint(cr);
  cairo_set_line_cap(cr, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
  DrawHeader(cr, evaluation, labels);
  DrawMap(cr, map, evaluation.aligned_pairs);
  DrawErrors(cr, errors, evaluation);
  CheckStatus(cairo_status(cr));

  std::string png;
  CheckStatus(cairo_surface_write_to_png_stream(surface.get(), &AppendBytes, &png));
  return png;
}

void WriteTrajectoryPlot(const std::string& path, const TrajectoryEvaluation& evaluation,
                         const TrajectoryPlotLabels& labels) {
  WriteFileAtomically(path, RenderTrajectoryPlot(evaluation, labels));
}

}  // namespace arborslam
