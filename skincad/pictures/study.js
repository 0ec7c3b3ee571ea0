// The study's data is that of `page` in study_page.py. A column's head sorts, a row or a point shows its design.
const data = JSON.parse(document.getElementById('data').textContent)
const get = id => document.getElementById(id)
const order = data.rows.map((_, i) => i)
let rising = true, column = 0, chosen = -1

function word(value) {
  if (value === null) return ''
  if (typeof value === 'number') return String(Number(value.toPrecision(5)))
  return value === true ? 'yes' : value === false ? 'no' : value
}

function fillTable() {
  get('rows').replaceChildren(...order.map(i => {
    const row = document.createElement('tr')
    row.className = i === chosen ? 'chosen' : data.refused[i] ? 'refused' : ''
    row.onclick = () => choose(i)
    row.append(...data.rows[i].map(value => {
      const cell = document.createElement('td')
      cell.textContent = word(value)
      if (typeof value === 'string') cell.className = 'text'
      return cell
    }))
    return row
  }))
}

function sortBy(number) {
  rising = number === column ? !rising : true
  column = number
  order.sort((a, b) => {
    const [x, y] = [data.rows[a][number], data.rows[b][number]]
    if (x === y) return a - b
    if (x === null || y === null) return x === null ? 1 : -1  // what a row has not comes last
    return (x < y) === rising ? -1 : 1
  })
  fillTable()
}

function choose(i) {
  chosen = i
  get('which').textContent = 'Row ' + data.rows[i][0]
  get('design').value = data.designs[i]
  fillTable()
  plot()
}

function draw(parent, name, attributes, text = '') {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name)
  for (const key in attributes) element.setAttribute(key, attributes[key])
  element.textContent = text
  parent.append(element)
  return element
}

function ends(values) {
  const low = Math.min(...values), high = Math.max(...values)
  const margin = 0.05 * ((high - low) || Math.abs(low) || 1)
  return [low - margin, high + margin]
}

function plot() {
  const picture = get('plot'), across = +get('x').value, up = +get('y').value
  picture.replaceChildren()
  const shown = order.filter(i => [across, up].every(c => typeof data.rows[i][c] === 'number'))
  if (!shown.length) return
  const [left, right] = ends(shown.map(i => data.rows[i][across]))
  const [low, high] = ends(shown.map(i => data.rows[i][up]))
  const x = value => 60 + 480 * (value - left) / (right - left)
  const y = value => 300 - 280 * (value - low) / (high - low)
  for (let k = 0; k <= 4; k++) {
    const u = left + (right - left) * k / 4, v = low + (high - low) * k / 4
    draw(picture, 'text', { x: x(u), y: 316, 'font-size': 10, 'text-anchor': 'middle' }, word(u))
    draw(picture, 'text', { x: 55, y: y(v) + 3, 'font-size': 10, 'text-anchor': 'end' }, word(v))
    draw(picture, 'line', { x1: 60, x2: 540, y1: y(v), y2: y(v), stroke: '#eee' })
  }
  draw(picture, 'text', { x: 300, y: 334, 'font-size': 11, 'text-anchor': 'middle' }, data.head[across])
  draw(picture, 'text',
    { x: -160, y: 12, 'font-size': 11, 'text-anchor': 'middle', transform: 'rotate(-90)' }, data.head[up])
  for (const i of shown) {
    const point = draw(picture, 'circle', {
      cx: x(data.rows[i][across]), cy: y(data.rows[i][up]), r: i === chosen ? 7 : 4,
      fill: i === chosen ? '#c1531f' : data.refused[i] ? '#bbb' : '#1f5fa8', 'fill-opacity': 0.75,
    })
    draw(point, 'title', {}, 'row ' + data.rows[i][0])
    point.onclick = () => choose(i)
  }
}

data.head.forEach((name, number) => {
  const head = document.createElement('th')
  head.textContent = name
  head.onclick = () => sortBy(number)
  get('head').append(head)
  if (!data.rows.some(row => typeof row[number] === 'number')) return
  for (const axis of ['x', 'y']) {
    const option = document.createElement('option')
    option.value = number
    option.textContent = name
    get(axis).append(option)
  }
})
for (const axis of ['x', 'y']) {
  get(axis).value = data[axis]
  get(axis).onchange = plot
}
get('copy').onclick = () => { get('design').select(); document.execCommand('copy') }
fillTable()
plot()
