// One quantity on a slider: while it moves the lumped chain answers, the newest wish first; when it rests the rod may answer too.
export default {
  emits: ["begin", "move", "moving", "rest", "settle", "keep"],
  props: { quantities: Array, rod: Boolean, floats: Boolean },
  data() {
    return { key: "", value: 0, text: "", sentence: "", numbers: [], asked: false, waiting: null, busy: false, slow: false, rodWanted: this.rod,
      rodSays: "", took: 0, times: [], started: 0, rested: null, typed: null, kept: "",
      floatSays: "", settled: null };
  },
  computed: {
    chosen() { return this.quantities.find((one) => one.key === this.key); },
    // The float speed stands first: it is searched for when the slider rests.
    shownNumbers() {
      const first = this.floats && this.numbers.length ? [{ label: "Float speed, about", value: this.floatSays || "computing", unit: "" }] : [];
      return [...first, ...this.numbers];
    },
    step() { return this.chosen ? this.chosen.step : 1; },
  },
  // The case changed: what was moved is moved no more, and the curve is asked for anew.
  watch: { quantities() {
    if (!this.chosen) { this.key = ""; return; }
    this.asked = false;
    this.value = this.chosen.value;
    this.ask();
  } },
  methods: {
    words(value) { return Number(Number(value).toPrecision(5)).toString(); },
    given() { return this.words(this.value) + (this.chosen.unit ? " " + this.chosen.unit : ""); },
    pick() { this.value = this.chosen ? this.chosen.value : 0; this.kept = ""; this.rodSays = ""; if (this.chosen) { this.asked = false; this.ask(); } },
    move(value) { this.value = Number(value); this.asked = true; this.kept = ""; this.ask(); },
    type(text) {
      this.typed = null;
      const value = Number.parseFloat(text);
      if (Number.isFinite(value)) { this.move(value); } else { this.sentence = "Type a number in " + (this.chosen.unit || "the unit shown") + "."; }
    },
    ask() {
      clearTimeout(this.rested);
      clearTimeout(this.settled);
      this.floatSays = "";
      if (this.slow) { this.slow = false; this.$emit("moving"); }
      const wish = { key: this.key, value: this.given(), began: performance.now() };
      if (this.busy) { this.waiting = wish; return; }
      this.busy = true;
      this.started = wish.began;
      this.$emit("move", { key: wish.key, value: wish.value });
    },
    // What the server answers: the figure, numbers, a sentence where the chain says no.
    answer(figure, numbers, sentence) {
      this.sentence = sentence;
      this.busy = false;
      if (figure.data) {
        this.numbers = numbers;
        this.draw(figure);
        this.took = performance.now() - this.started;
        this.times.push(this.took);
        window.valvetrainSlider = this.times;
      }
      if (this.waiting) { const next = this.waiting; this.waiting = null; this.ask(next); } else { this.settle(); this.rest(); }
    },
    settle() {
      clearTimeout(this.settled);
      if (!this.floats || this.sentence) { return; }
      this.settled = setTimeout(() => { this.slow = true; this.$emit("settle", { key: this.key, value: this.given(), asked: this.asked }); }, 300);
    },
    floatAnswer(words) { this.floatSays = words; },
    async draw(figure) {
      if (typeof Plotly === "undefined") { await window.valvetrainDrawing; }
      valvetrainFigures.draw(this.$refs.plot, figure);
    },
    rest() {
      clearTimeout(this.rested);
      if (!this.rodWanted || !this.asked || this.sentence) { return; }
      this.rested = setTimeout(() => { this.slow = true; this.rodSays = "The rod is running."; this.$emit("rest", { key: this.key, value: this.given() }); }, 500);
    },
    rodAnswer(figure, sentence) {
      this.slow = false;
      this.rodSays = sentence;
      if (figure.data) { this.draw(figure); }
    },
    keep() { this.asked = false; this.kept = "Kept: " + this.given() + "."; this.$emit("keep", { key: this.key, value: this.given() }); },
    reset() { this.typed = null; this.value = this.chosen.value; this.asked = false; this.kept = ""; this.ask(); },
    toggleRod() { if (this.rodWanted) { this.rest(); } else { clearTimeout(this.rested); } },
  },
  template: `
<section class="panel live" aria-labelledby="live-title">
  <div class="split"><h2 id="live-title">What if</h2><p class="hint">Numbers, curve and picture follow a quantity while you move it.{{ floats ? " A sweep searches the float speed finer." : "" }}</p></div>
  <div class="row end live-row">
    <div class="labelled quantity"><label for="live-quantity">Quantity</label>
      <select id="live-quantity" v-model="key" @change="pick" @focus.once="$emit('begin')"><option value="" disabled>choose …</option>
        <option v-for="one in quantities" :key="one.key" :value="one.key">{{ one.label }}</option>
      </select></div>
    <template v-if="chosen">
      <div class="labelled slide"><label for="live-slider">{{ chosen.label }}: {{ words(chosen.low) }} to {{ words(chosen.high) }} {{ chosen.unit }}</label>
        <input id="live-slider" type="range" :min="chosen.low" :max="chosen.high" :step="step" :value="value" :aria-valuetext="given()" @input="move($event.target.value)"></div>
      <div class="labelled number"><label for="live-value">{{ chosen.unit ? "Value (" + chosen.unit + ")" : "Value" }}</label>
        <input id="live-value" type="text" inputmode="decimal" :value="typed ?? words(value)" @input="typed = $event.target.value"
          @change="type($event.target.value)" @keydown.escape="reset"></div>
    </template>
  </div>
  <div class="row" v-if="chosen">
    <label class="check" for="live-rod"><input type="checkbox" id="live-rod" v-model="rodWanted" @change="toggleRod">Run the finite-element rod when I stop</label>
    <button type="button" class="button small" :disabled="!asked" @click="keep">Keep this value</button>
    <button type="button" class="button small" :disabled="!asked" @click="reset">Back to the case</button>
    <span class="said" role="status">{{ [kept, rodSays].filter(Boolean).join(" ") }}</span>
  </div>
  <p v-if="busy && !numbers.length" class="said" role="status">The chain is being started.</p>
  <p v-if="sentence" class="refusal" role="alert">{{ sentence }}</p>
  <dl class="numbers" v-if="numbers.length" aria-live="polite"><div v-for="one in shownNumbers" :key="one.label"><dt>{{ one.label }}</dt><dd>{{ one.value }} <small>{{ one.unit }}</small></dd></div></dl>
  <div v-show="numbers.length" class="plot" ref="plot" role="group" aria-label="Spring force over the cam angle: case, moved quantity and rod" style="height:300px"></div>
</section>`,
};
