package vantage.spy;

import java.awt.BasicStroke;
import java.awt.Color;
import java.awt.Dimension;
import java.awt.Font;
import java.awt.Graphics;
import java.awt.Graphics2D;
import java.awt.Rectangle;
import java.awt.RenderingHints;
import java.awt.geom.Ellipse2D;
import java.awt.geom.Line2D;
import java.awt.geom.Path2D;
import java.io.IOException;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMSubscriber;
import vantage_msgs.observability_t;

/**
 * Left: the trigger's measure with its threshold, w_v, w_r and w_c over the last half minute. Right: the
 * observability ellipsoid in the plane of its first two axes, and all singular values as bars.
 */
final class ObservabilityView extends ViewPlugin.View implements LCMSubscriber {
  private static final Color BLUE = new Color(0x44, 0x77, 0xaa);
  private static final Color GREEN = new Color(0x22, 0x88, 0x33);
  private static final Color ORANGE = new Color(0xe0, 0x80, 0x30);
  private static final Color PURPLE = new Color(0xaa, 0x33, 0x77);
  private static final Color RED = new Color(0xb9, 0x1c, 0x1c);
  private static final String[] MEASURES = {"w_c^(1/s) [px/rad]", "w_c", "sigma_min [px/rad]", "1 / condition"};

  private final String channel;
  private final TimePlot trigger =
      new TimePlot("trigger", false, 2).curve("value", GREEN, false).curve("threshold", RED, true);
  private final TimePlot view = new TimePlot("observability of the view", true, 1).curve("w_v", BLUE, false);
  private final TimePlot arm = new TimePlot("manipulability of the arm", true, 1).curve("w_r", ORANGE, false);
  private final TimePlot both = new TimePlot("composite", true, 1).curve("w_c", PURPLE, false);
  private observability_t last;
  private String problem = "waiting for a message";

  ObservabilityView(String channel) {
    this.channel = channel;
    setPreferredSize(new Dimension(900, 560));
  }

  @Override
  void start(LCM lcm) {
    lcm.subscribe(channel, this);
  }

  @Override
  void stop(LCM lcm) {
    lcm.unsubscribe(channel, this);
  }

  @Override
  public void messageReceived(LCM lcm, String name, LCMDataInputStream stream) {
    try {
      take(new observability_t(stream));
    } catch (IOException | RuntimeException error) {
      synchronized (this) {
        problem = "cannot read " + name + ": " + error.getMessage();
      }
    }
    repaint();
  }

  private synchronized void take(observability_t message) {
    last = message;
    problem = null;
    double t = 1e-6 * message.utime;
    boolean measured = message.k > 0; // Before the first image there are no measures.
    trigger.add(t, measured ? message.trigger_value : Double.NaN, message.threshold);
    view.add(t, measured ? message.w_v : Double.NaN);
    arm.add(t, measured ? message.w_r : Double.NaN);
    both.add(t, measured ? message.w_c : Double.NaN);
  }

  @Override
  protected synchronized void paintComponent(Graphics graphics) {
    Graphics2D g = (Graphics2D) graphics;
    g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
    g.setRenderingHint(RenderingHints.KEY_STROKE_CONTROL, RenderingHints.VALUE_STROKE_PURE);
    g.setRenderingHint(
        RenderingHints.KEY_TEXT_ANTIALIASING, RenderingHints.VALUE_TEXT_ANTIALIAS_ON);
    g.setColor(new Color(246, 247, 249));
    g.fillRect(0, 0, getWidth(), getHeight());
    g.setFont(new Font(Font.SANS_SERIF, Font.PLAIN, 12));
    g.setColor(Color.DARK_GRAY);
    if (problem != null) g.drawString(problem, 12, getHeight() - 8);
    if (last == null) return;
    int head = 34;
    paintHead(g);
    int left = getWidth() * 3 / 5;
    int height = (getHeight() - head) / 4;
    TimePlot[] plots = {trigger, view, arm, both};
    for (int i = 0; i < plots.length; ++i) {
      plots[i].paint(g, new Rectangle(0, head + i * height, left, height));
    }
    int side = (getHeight() - head) * 3 / 5;
    paintEllipse(g, new Rectangle(left + 8, head, getWidth() - left - 20, side));
    paintBars(
        g, new Rectangle(left + 8, head + side + 24, getWidth() - left - 20, getHeight() - head - side - 36));
  }

  private void paintHead(Graphics2D g) {
    boolean low = last.trigger_value < last.threshold;
    g.setFont(g.getFont().deriveFont(Font.BOLD, 14f));
    g.setColor(low ? RED : GREEN);
    String measure =
        last.trigger_measure >= 0 && last.trigger_measure < MEASURES.length
            ? MEASURES[last.trigger_measure]
            : "?";
    String text =
        String.format("%s %.4g %s %.4g", measure, last.trigger_value, low ? "<" : ">=", last.threshold);
    if (low) text += "   low because of " + last.cause_name;
    g.drawString(text, 12, 22);
    int width = g.getFontMetrics().stringWidth(text);
    g.setColor(Color.DARK_GRAY);
    g.setFont(g.getFont().deriveFont(Font.PLAIN, 12f));
    g.drawString(
        String.format(
            "camera %s, %d moves, last for %s; one pixel may hide %.3g mm",
            last.active_state_name, last.camera_moves, last.active_reason_name, last.mm_per_px),
        12 + width + 24,
        22);
  }

  /**
   * The plane of axes 1 and 2. With two features these are the image's own directions, so the ellipse is
   * drawn as it lies in (s1, s2); with more its axes are drawn along the window's.
   */
  private void paintEllipse(Graphics2D g, Rectangle area) {
    g.setColor(Color.WHITE);
    g.fill(area);
    g.setColor(Color.GRAY);
    g.draw(area);
    g.setColor(Color.DARK_GRAY);
    boolean image = last.k == 2;
    g.drawString(
        image ? "ellipsoid of J_c in feature space" : "ellipsoid of J_c, plane of its first two axes",
        area.x + 8,
        area.y + 16);
    if (last.num_sigma < 1) return;
    double[] first = {last.sigma[0], 0};
    double[] second = {0, last.num_sigma > 1 ? last.sigma[1] : 0};
    if (image && last.num_axes > 0) {
      first = last.axes[0];
      second = last.num_axes > 1 ? last.axes[1] : new double[2];
    }
    double radius = 0.42 * Math.min(area.width, area.height - 24);
    double scale = radius / Math.max(1e-12, Math.max(last.sigma[0], geometric() ? last.threshold : 0));
    double x = area.getCenterX();
    double y = area.getCenterY() + 8;
    // A round ellipsoid at the threshold, for comparison.
    if (geometric()) {
      g.setColor(RED);
      g.setStroke(new BasicStroke(1.2f, BasicStroke.CAP_BUTT, BasicStroke.JOIN_ROUND, 1f, new float[] {6f, 4f}, 0f));
      double r = scale * last.threshold;
      g.draw(new Ellipse2D.Double(x - r, y - r, 2 * r, 2 * r));
    }
    Path2D path = new Path2D.Double();
    for (int i = 0; i <= 120; ++i) {
      double a = 2 * Math.PI * i / 120;
      // v goes down in the image and in the window alike.
      double px = x + scale * (Math.cos(a) * first[0] + Math.sin(a) * second[0]);
      double py = y + scale * (Math.cos(a) * first[1] + Math.sin(a) * second[1]);
      if (i == 0) path.moveTo(px, py);
      else path.lineTo(px, py);
    }
    g.setStroke(new BasicStroke(2f));
    g.setColor(new Color(0x44, 0x77, 0xaa, 60));
    g.fill(path);
    g.setColor(BLUE);
    g.draw(path);
    g.setColor(PURPLE);
    g.draw(new Line2D.Double(x, y, x + scale * first[0], y + scale * first[1]));
    g.draw(new Line2D.Double(x, y, x + scale * second[0], y + scale * second[1]));
    g.setColor(Color.DARK_GRAY);
    String text = String.format("\u03c31 %.4g", last.sigma[0]);
    if (last.num_sigma > 1) text += String.format("   \u03c32 %.4g px/rad", last.sigma[1]);
    if (geometric()) text += "   dashed: threshold";
    g.drawString(text, area.x + 8, area.y + area.height - 8);
  }

  private boolean geometric() {
    return last.trigger_measure == 0;
  }

  private void paintBars(Graphics2D g, Rectangle area) {
    g.setColor(Color.DARK_GRAY);
    g.drawString(
        String.format("singular values of J_c [px/rad], rank %d, condition %.3g", last.rank, last.condition),
        area.x,
        area.y - 6);
    if (last.num_sigma < 1) return;
    double greatest = Math.log10(Math.max(last.sigma[0], 1e-12));
    int height = Math.min(22, area.height / last.num_sigma);
    for (int i = 0; i < last.num_sigma; ++i) {
      double h = last.sigma[i] > 0 ? Math.log10(last.sigma[i]) : greatest - 4;
      // Four decades, down from the greatest.
      double share = Math.max(0.01, Math.min(1, 1 - (greatest - h) / 4));
      int y = area.y + i * height;
      g.setColor(i == last.num_sigma - 1 ? ORANGE : BLUE);
      g.fillRect(area.x + 24, y + 2, (int) (share * (area.width - 100)), height - 4);
      g.setColor(Color.DARK_GRAY);
      g.drawString("\u03c3" + (i + 1), area.x, y + height - 6);
      g.drawString(
          String.format("%.4g", last.sigma[i]),
          area.x + 30 + (int) (share * (area.width - 100)),
          y + height - 6);
    }
  }
}
