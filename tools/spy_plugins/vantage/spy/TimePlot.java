package vantage.spy;

import java.awt.BasicStroke;
import java.awt.Color;
import java.awt.Graphics2D;
import java.awt.Rectangle;
import java.awt.geom.Path2D;
import java.util.ArrayDeque;

/** Curves over the last seconds, on a linear or a logarithmic axis. */
final class TimePlot {
  static final double SPAN = 30.0; // [s].

  private static final class Curve {
    final String name;
    final Color colour;
    final boolean dashed;

    Curve(String name, Color colour, boolean dashed) {
      this.name = name;
      this.colour = colour;
      this.dashed = dashed;
    }
  }

  private final String title;
  private final boolean logarithmic;
  private final Curve[] curves;
  private int numCurves;
  private final ArrayDeque<double[]> samples = new ArrayDeque<>(); // (t, values...)

  TimePlot(String title, boolean logarithmic, int most) {
    this.title = title;
    this.logarithmic = logarithmic;
    curves = new Curve[most];
  }

  TimePlot curve(String name, Color colour, boolean dashed) {
    curves[numCurves++] = new Curve(name, colour, dashed);
    return this;
  }

  /** Values in the order of the curves, at t [s]. */
  void add(double t, double... values) {
    // A clock that jumps back is a sender that was started anew.
    if (!samples.isEmpty() && t < samples.peekLast()[0]) samples.clear();
    double[] sample = new double[values.length + 1];
    sample[0] = t;
    System.arraycopy(values, 0, sample, 1, values.length);
    samples.addLast(sample);
    while (t - samples.peekFirst()[0] > SPAN) samples.removeFirst();
  }

  private double height(double value) {
    if (!logarithmic) return value;
    return value > 0 ? Math.log10(value) : Double.NaN;
  }

  void paint(Graphics2D g, Rectangle area) {
    Rectangle box = new Rectangle(area.x + 58, area.y + 20, area.width - 70, area.height - 30);
    g.setColor(Color.WHITE);
    g.fill(box);
    double least = Double.POSITIVE_INFINITY;
    double greatest = Double.NEGATIVE_INFINITY;
    for (double[] sample : samples) {
      for (int i = 1; i < sample.length; ++i) {
        double h = height(sample[i]);
        if (!Double.isFinite(h)) continue;
        least = Math.min(least, h);
        greatest = Math.max(greatest, h);
      }
    }
    if (least <= greatest) {
      double margin = Math.max(0.08 * (greatest - least), logarithmic ? 0.1 : 1e-9 + 0.02 * Math.abs(greatest));
      least -= margin;
      greatest += margin;
      if (!logarithmic && least < 0.5 * greatest) least = Math.min(0, least);
      grid(g, box, least, greatest);
      for (int i = 0; i < numCurves; ++i) draw(g, box, least, greatest, i);
    }
    g.setColor(Color.GRAY);
    g.setStroke(new BasicStroke(1f));
    g.draw(box);
    legend(g, area, box);
  }

  private void grid(Graphics2D g, Rectangle box, double least, double greatest) {
    g.setStroke(new BasicStroke(1f));
    for (int i = 0; i <= 3; ++i) {
      double h = least + (greatest - least) * i / 3;
      int y = (int) Math.round(box.y + box.height * (1 - i / 3.0));
      g.setColor(new Color(228, 230, 234));
      g.drawLine(box.x, y, box.x + box.width, y);
      g.setColor(Color.DARK_GRAY);
      g.drawString(label(logarithmic ? Math.pow(10, h) : h), box.x - 56, y + 4);
    }
  }

  private static String label(double value) {
    double size = Math.abs(value);
    if (size != 0 && (size >= 1e4 || size < 1e-3)) return String.format("%.1e", value);
    return String.format(size < 1 ? "%.4f" : size < 100 ? "%.2f" : "%.0f", value);
  }

  private void draw(Graphics2D g, Rectangle box, double least, double greatest, int curve) {
    double end = samples.peekLast()[0];
    Path2D path = new Path2D.Double();
    boolean down = false;
    for (double[] sample : samples) {
      double h = curve + 1 < sample.length ? height(sample[curve + 1]) : Double.NaN;
      if (!Double.isFinite(h)) {
        down = false;
        continue;
      }
      double x = box.x + box.width * (1 - (end - sample[0]) / SPAN);
      double y = box.y + box.height * (1 - (h - least) / (greatest - least));
      if (down) path.lineTo(x, y);
      else path.moveTo(x, y);
      down = true;
    }
    g.setColor(curves[curve].colour);
    g.setStroke(
        curves[curve].dashed
            ? new BasicStroke(1.5f, BasicStroke.CAP_BUTT, BasicStroke.JOIN_ROUND, 1f, new float[] {6f, 4f}, 0f)
            : new BasicStroke(2f));
    g.draw(path);
  }

  private void legend(Graphics2D g, Rectangle area, Rectangle box) {
    g.setColor(Color.DARK_GRAY);
    g.drawString(title, box.x, area.y + 14);
    double[] last = samples.peekLast();
    int x = box.x + box.width;
    for (int i = numCurves - 1; i >= 0; --i) {
      String text =
          curves[i].name + (last == null || i + 1 >= last.length ? "" : " " + label(last[i + 1]));
      x -= g.getFontMetrics().stringWidth(text) + 12;
      g.setColor(curves[i].colour);
      g.drawString(text, x, area.y + 14);
    }
  }
}
