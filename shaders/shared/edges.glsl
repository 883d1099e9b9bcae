// Pixels where several surfaces meet: how `edges` tells the last stage which neighbour shows the other surface, and how much of it.

const ivec2 NEIGHBOURS[8] = ivec2[](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1), ivec2(1, 1), ivec2(-1, 1), ivec2(1, -1), ivec2(-1, -1));

// What is stored: 0, or 1 + 8 * (share of the other surface in eighths, less one) + number of the neighbour that shows it, over 255.
float encode_edge(int eighths, int neighbour) { return float(1 + 8 * (eighths - 1) + neighbour) / 255.0; }

// Whether a pixel has another surface; its share, and the neighbour that shows it.
bool decode_edge(float stored, out float share, out ivec2 neighbour) {
    int edge = int(stored * 255.0 + 0.5) - 1;
    if (edge < 0) return false;
    share = float(edge / 8 + 1) / 8.0;
    neighbour = NEIGHBOURS[edge % 8];
    return true;
}
